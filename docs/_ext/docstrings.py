"""Docstrings are Google style with Markdown's fences and backticks; Sphinx reads reStructuredText."""

import re

SPAN = re.compile(r"(`[^`]+`)")


def setup(app):
    """Translate before napoleon reads the sections."""
    app.connect("autodoc-process-docstring", _translate, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _translate(_app, _what, _name, _obj, _options, lines):
    lines[:] = translated(lines)


def translated(lines):
    """The lines of a docstring, its fences as literal blocks and its signs as what they are."""
    out, fenced, section, bullet, returns = [], False, "", False, ""
    for line in lines:
        indent, text = re.fullmatch(r"( *)(.*)", line).groups()
        if (heading := re.fullmatch(r"([A-Z]\w+):", text)) and not indent:
            section, bullet = heading[1], False
            if section == "Returns":  # napoleon would take what is before a colon for a type
                returns = ":returns: "
                continue
        if text.startswith("```"):
            fenced = not fenced
            out += [f"{indent}::", ""] if fenced else [""]
        elif fenced:
            out.append(f"    {line}" if text else "")
        elif text.startswith((">>>", "...")):
            out.append(line)
        else:
            text = "".join(part if part.startswith("`") else _escaped(part) for part in SPAN.split(text))
            if section == "References" and text.startswith("["):
                text, bullet = f"* {text}", True
            elif bullet and text:  # goes on with the entry
                text = f"  {text}"
            if section == "Returns" and text and returns:
                indent, returns = returns, ""
            out.append(f"{indent}{text}" if text else "")
    return out


def _escaped(text):
    """Asterisks, bars and final underscores that reStructuredText would take for markup."""
    return re.sub(r"(\*|\||(?<=\w)_(?!\w))", r"\\\1", text)
