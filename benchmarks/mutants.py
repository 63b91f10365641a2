"""Mutants of a module: copies with one small fault each, as a programmer in a hurry would make it."""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator
from dataclasses import dataclass

_OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Div, ast.Mod: ast.Mult,
    ast.Pow: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip

# Exchanging the arguments of these changes nothing.
_SYMMETRIC = frozenset(("max", "min", "maximum", "minimum", "hypot", "clip", "allclose", "isclose", "array_equal"))


# Guards against what cannot happen here: lists of unlike lengths, a machine whose files are not in UTF-8.
_GUARDS = frozenset(("strict", "encoding"))


class _Tested(ast.AST):
    """The condition of a branch or a loop."""

    _attributes = ("lineno", "col_offset", "end_lineno", "end_col_offset")
    __match_args__ = ("expression",)

    def __init__(self, expression: ast.expr) -> None:
        super().__init__()
        self.expression = expression


@dataclass(frozen=True)
class Mutant:
    """One fault.

    Attributes:
        line: where it is, counted from 1.
        before: the line as it stands.
        after: the line with the fault.
        source: the whole module with the fault.
        called: whether it is in the body of a function; else it runs on import.
    """

    line: int
    before: str
    after: str
    source: str
    called: bool

    @property
    def key(self) -> str:
        """What names it, wherever in the module it stands."""
        return f"{self.before} -> {self.after}"


def mutants(source: str, count: int, seed: str) -> list[Mutant]:
    """Choose some of a module's mutants at random.

    Args:
        source: of the module.
        count: at most so many.
        seed: the same seed makes the same choice.

    Returns:
        In the order of their lines.
    """
    found = list({mutant.source: mutant for mutant in _all(source)}.values())
    chosen = random.Random(seed).sample(found, min(count, len(found)))
    return sorted(chosen, key=lambda mutant: mutant.line)


def _all(source: str) -> Iterator[Mutant]:
    lines = source.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode()))
    data, tree = source.encode(), ast.parse(source)
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    bodies = [range(node.body[0].lineno, node.body[-1].end_lineno + 1) for node in functions]
    for node in _code(tree):
        for fault in _faults(node):
            begin = starts[node.lineno - 1] + node.col_offset
            end = starts[node.end_lineno - 1] + node.end_col_offset
            mutated = (data[:begin] + fault.encode() + data[end:]).decode()
            try:
                ast.parse(mutated)
            except SyntaxError:
                continue
            after = mutated.splitlines()[node.lineno - 1]
            called = any(node.lineno in body for body in bodies)
            yield Mutant(node.lineno, lines[node.lineno - 1].strip(), after.strip(), mutated, called)


def _code(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes that run: no annotations, decorators, type checkers' imports, guards or words."""
    left_out = {"annotation", "returns", "decorator_list", "type_params"}
    if isinstance(node, ast.UnaryOp) and ast.unparse(node) == "-1":
        yield node  # and not its 1: to many functions of NumPy -2 means the same
        return
    if isinstance(node, ast.keyword) and node.arg in _GUARDS:
        return
    if isinstance(node, ast.JoinedStr) or (isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)):
        return
    if hasattr(node, "lineno"):
        yield node
    if isinstance(node, ast.If | ast.While | ast.IfExp):
        yield ast.copy_location(_Tested(node.test), node.test)
    for name, value in ast.iter_fields(node):
        if name not in left_out:
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from _code(child)


def _faults(node: ast.AST) -> Iterator[str]:
    """What may stand in place of a node."""
    match node:
        case ast.BinOp(left, op, right) if type(op) in _OPERATORS:
            yield _text(ast.BinOp(left, _OPERATORS[type(op)](), right))
        case ast.BinOp(left, ast.MatMult() as op, right):
            yield _text(ast.BinOp(right, op, left))
        case ast.AugAssign(target, op, value) if type(op) in _OPERATORS:
            yield ast.unparse(ast.AugAssign(target, _OPERATORS[type(op)](), value))
        case ast.Compare(left, [op, *others], right):
            yield _text(ast.Compare(left, [_OPERATORS[type(op)](), *others], right))
        case ast.BoolOp(op, values):
            yield _text(ast.BoolOp(_OPERATORS[type(op)](), values))
        case ast.UnaryOp(ast.Not() | ast.USub() | ast.Invert(), operand):
            yield _text(operand)
        case ast.Constant(bool() as value):
            yield str(not value)
        case ast.Constant(int() | float() as value):
            yield str(value + 1 if isinstance(value, int) else 2 * value or 1.0)
        case _Tested(expression) if not isinstance(expression, ast.Compare | ast.BoolOp | ast.UnaryOp):
            yield f"(not {_text(expression)})"
        case ast.Raise() | ast.Expr(ast.Call()):
            yield "pass"
        case ast.Call(function, arguments, keywords):
            yield from _calls(function, arguments, keywords)
        case ast.Subscript(value, ast.Slice(lower, upper)) if lower or upper:
            yield ast.unparse(ast.Subscript(value, ast.Slice(None, None), ast.Load()))


def _calls(function: ast.expr, arguments: list[ast.expr], keywords: list[ast.keyword]) -> Iterator[str]:
    """Two arguments exchanged; each keyword forgotten, but for guards."""
    texts = [ast.unparse(argument) for argument in arguments[:2]]
    if len(set(texts)) == 2 and ast.unparse(function).removeprefix("np.") not in _SYMMETRIC:
        yield ast.unparse(ast.Call(function, [arguments[1], arguments[0], *arguments[2:]], keywords))
    for k in (k for k, keyword in enumerate(keywords) if keyword.arg not in _GUARDS):
        yield ast.unparse(ast.Call(function, arguments, keywords[:k] + keywords[k + 1 :]))


def _text(node: ast.expr) -> str:
    return f"({ast.unparse(node)})"
