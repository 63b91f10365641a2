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
    out, fenced, section = [], False, ""
    for line in lines:
        if heading := re.fullmatch(r"\s*([A-Z]\w+):", line):
            section = heading[1]
        indent = line[: len(line) - len(line.lstrip())]
        if line.strip().startswith("```"):
            fenced = not fenced
            out += [f"{indent}::", ""] if fenced else [""]
        elif fenced:
            out.append(f"    {line}" if line.strip() else "")
        elif line.lstrip().startswith((">>>", "...")):
            out.append(line)
        else:
            if section == "References" and line.lstrip().startswith("["):
                line = f"{indent}* {line.lstrip()}"  # an entry a line
            out.append("".join(part if part.startswith("`") else _escaped(part) for part in SPAN.split(line)))
    return out


def _escaped(text):
    """Asterisks, bars and final underscores that reStructuredText would take for markup."""
    return re.sub(r"(\*|\||(?<=\w)_(?!\w))", r"\\\1", text)
