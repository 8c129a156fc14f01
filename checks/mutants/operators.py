"""Mutants of one source file: the operators, and where in the syntax tree each of them applies.

A mutant replaces one stretch of the source by another one of as many lines, so that every other line keeps its number.
Text and annotations are left alone: a message, a docstring or a type has no behaviour that a test must hold.
"""

from __future__ import annotations

import ast
import copy
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["OPERATORS", "Mutant", "mutants_of"]

OPERATORS = (
    "arithmetic", "sign", "comparison", "boundary", "boolean", "condition", "constant", "function", "arguments",
    "return", "statement",
)  # fmt: skip

ARITHMETIC: dict[type[ast.operator], ast.operator] = {
    ast.Add: ast.Sub(), ast.Sub: ast.Add(), ast.Mult: ast.Div(), ast.Div: ast.Mult(), ast.Pow: ast.Mult(),
    ast.FloorDiv: ast.Mult(), ast.Mod: ast.Mult(), ast.BitAnd: ast.BitOr(), ast.BitOr: ast.BitAnd(),
    ast.LShift: ast.RShift(), ast.RShift: ast.LShift(),
}  # fmt: skip
COMPARISON: dict[type[ast.cmpop], ast.cmpop] = {
    ast.Lt: ast.GtE(), ast.LtE: ast.Gt(), ast.Gt: ast.LtE(), ast.GtE: ast.Lt(), ast.Eq: ast.NotEq(),
    ast.NotEq: ast.Eq(), ast.Is: ast.IsNot(), ast.IsNot: ast.Is(), ast.In: ast.NotIn(), ast.NotIn: ast.In(),
}  # fmt: skip
BOUNDARY: dict[type[ast.cmpop], ast.cmpop] = {
    ast.Lt: ast.LtE(), ast.LtE: ast.Lt(), ast.Gt: ast.GtE(), ast.GtE: ast.Gt(),
}  # fmt: skip
FUNCTIONS = {"min": "max", "max": "min", "any": "all", "all": "any", "floor": "ceil", "ceil": "floor", "sin": "cos",
             "cos": "sin", "argmin": "argmax", "argmax": "argmin", "minimum": "maximum", "maximum": "minimum",
             "zeros": "ones", "ones": "zeros"}  # fmt: skip
# The order of their arguments is part of the language, and a mutant of it raises at once.
FIXED_ORDER = frozenset(
    {"isinstance", "getattr", "hasattr", "setattr", "super", "field", "cast", "TypeVar", "namedtuple"}
)


@dataclass(frozen=True)
class Mutant:
    """One change of one file.

    ``place`` is the first character and the end of the stretch in the file's text, ``line`` its first line and ``text``
    that line without indentation; ``statement`` the first and the last line of the statement it is in, of which only
    the head counts if others are in it; ``within`` the names of the classes and functions around it, outermost first,
    and ``runs_at_import`` whether no function is around it.
    """

    path: str
    place: tuple[int, int]
    line: int
    statement: tuple[int, int]
    within: tuple[str, ...]
    runs_at_import: bool
    operator: str
    before: str
    after: str
    text: str

    @property
    def change(self) -> str:
        """What is replaced by what, in one line."""
        return f"{' '.join(self.before.split())} -> {' '.join(self.after.split())}"

    @property
    def key(self) -> str:
        """A short name that does not change while the file does not."""
        told = f"{self.path}:{self.place}:{self.operator}:{self.text}:{self.before}:{self.after}"
        return hashlib.sha256(told.encode()).hexdigest()[:12]

    def applied(self, source: str) -> str:
        """Return the file's text with the change, and with as many lines."""
        padding = "\n" * (self.before.count("\n") - self.after.count("\n"))
        first, end = self.place
        return source[:first] + self.after.rstrip(")") + padding + ")" * _closing(self.after) + source[end:]


def _closing(text: str) -> int:
    """Return how many closing brackets end a text: the padding of lines goes before them."""
    return len(text) - len(text.rstrip(")"))


def mutants_of(path: str, source: str) -> list[Mutant]:
    """Return all mutants of a file, in the order of their places and operators."""
    visitor = _Visitor(path, source)
    visitor.visit(ast.parse(source))
    unique = {(one.place, one.operator, one.after): one for one in visitor.found}
    return sorted(unique.values(), key=lambda one: (one.place, OPERATORS.index(one.operator), one.after))


class _Visitor(ast.NodeVisitor):
    """Collects the mutants of a file."""

    def __init__(self, path: str, source: str) -> None:
        """Note where each line of the text begins, in characters."""
        self.path, self.source, self.found = path, source, list[Mutant]()
        self._lines = source.splitlines(keepends=True)
        self._starts = [0]
        for line in self._lines:
            self._starts.append(self._starts[-1] + len(line))
        self._within: list[str] = []
        self._functions = 0
        self._statement = (1, 1)
        self._assigned: list[set[str]] = [set()]

    def visit(self, node: ast.AST) -> None:
        """Visit a node; note which statement it is in."""
        before = self._statement
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            last = max(node.lineno, body[0].lineno - 1) if body else node.end_lineno
            self._statement = (node.lineno, last or node.lineno)
        super().visit(node)
        self._statement = before

    def _offset(self, line: int, column: int) -> int:
        """Return the place of a line and a column in bytes, as the syntax tree counts them, in the text."""
        return self._starts[line - 1] + len(self._lines[line - 1].encode()[:column].decode())

    def _add(self, node: ast.expr | ast.stmt, operator: str, after: str) -> None:
        """Keep a mutant that replaces a node's text."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        first = self._offset(node.lineno, node.col_offset)
        end = self._offset(node.end_lineno, node.end_col_offset)
        self.found.append(
            Mutant(
                self.path, (first, end), node.lineno, self._statement, tuple(self._within), not self._functions,
                operator, self.source[first:end], after, self._lines[node.lineno - 1].strip(),
            )
        )  # fmt: skip

    def _replace(self, node: ast.expr, operator: str, other: ast.expr) -> None:
        """Keep a mutant that replaces an expression by another one, in brackets."""
        after = ast.unparse(ast.fix_missing_locations(other))
        self._add(node, operator, after if isinstance(other, (ast.Constant, ast.Name)) else f"({after})")

    # What is left alone.

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        """Visit defaults and body; a name that is assigned twice may lose its later assignments."""
        if node.name == "__repr__":
            return
        for default in (*node.args.defaults, *node.args.kw_defaults):
            if default is not None:
                self.visit(default)
        self._within.append(node.name)
        self._functions += 1
        self._assigned.append({argument.arg for argument in ast.walk(node.args) if isinstance(argument, ast.arg)})
        for statement in node.body:
            self.visit(statement)
        self._assigned.pop()
        self._functions -= 1
        self._within.pop()

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        """Visit the body."""
        self._within.append(node.name)
        for statement in node.body:
            self.visit(statement)
        self._within.pop()

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Visit the value, not the annotation."""
        if node.value is not None:
            self.visit(node.value)

    def visit_JoinedStr(self, _node: ast.JoinedStr) -> None:
        """Leave text alone."""

    def visit_If(self, node: ast.If) -> None:
        """Leave imports for annotations alone; otherwise negate the condition."""
        if isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            return
        self._negate(node.test)
        self.generic_visit(node)

    def visit_While(self, node: ast.While) -> None:
        """Negate the condition."""
        self._negate(node.test)
        self.generic_visit(node)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        """Negate the condition."""
        self._negate(node.test)
        self.generic_visit(node)

    def _negate(self, test: ast.expr) -> None:
        """Keep a negated condition, unless a mutant of another operator is the same."""
        if isinstance(test, ast.Compare) and len(test.ops) == 1:
            return
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            return
        if not isinstance(test, ast.Constant):
            self._replace(test, "condition", ast.UnaryOp(ast.Not(), copy.deepcopy(test)))

    # Operators.

    def visit_BinOp(self, node: ast.BinOp) -> None:
        """Exchange an arithmetic operator."""
        texts = any(isinstance(side, ast.JoinedStr) or _is_text(side) for side in (node.left, node.right))
        other = ARITHMETIC.get(type(node.op))
        if other is not None and not texts:
            changed = copy.deepcopy(node)
            changed.op = other
            self._replace(node, "arithmetic", changed)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        """Remove a sign or a negation."""
        if isinstance(node.op, ast.USub):
            self._replace(node, "sign", copy.deepcopy(node.operand))
            if isinstance(node.operand, ast.Constant):
                return
        elif isinstance(node.op, ast.Not):
            self._replace(node, "boolean", copy.deepcopy(node.operand))
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        """Exchange each comparison for its contrary, and move its boundary."""
        for place, operator in enumerate(node.ops):
            for name, table in (("comparison", COMPARISON), ("boundary", BOUNDARY)):
                other = table.get(type(operator))
                if other is not None:
                    changed = copy.deepcopy(node)
                    changed.ops[place] = other
                    self._replace(node, name, changed)
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        """Exchange and for or."""
        changed = copy.deepcopy(node)
        changed.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        self._replace(node, "boolean", changed)
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        """Change a number or a truth value."""
        value = node.value
        if isinstance(value, bool):
            self._replace(node, "boolean", ast.Constant(not value))
        elif isinstance(value, int):
            self._replace(node, "constant", ast.Constant(value + 1))
        elif isinstance(value, float):
            self._replace(node, "constant", ast.Constant(2.0 * value if value else 1.0))

    def visit_Call(self, node: ast.Call) -> None:
        """Exchange a function for its counterpart, and neighbouring arguments for each other."""
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in FUNCTIONS:
            changed = copy.deepcopy(node)
            if isinstance(changed.func, ast.Attribute):
                changed.func.attr = FUNCTIONS[name]
            else:
                changed.func = ast.Name(FUNCTIONS[name])
            self._replace(node, "function", changed)
        starred = any(isinstance(argument, ast.Starred) for argument in node.args)
        if name not in FIXED_ORDER | FUNCTIONS.keys() and not starred:
            for place in range(len(node.args) - 1):
                if ast.dump(node.args[place]) != ast.dump(node.args[place + 1]):
                    changed = copy.deepcopy(node)
                    changed.args[place : place + 2] = changed.args[place : place + 2][::-1]
                    self._replace(node, "arguments", changed)
        self.generic_visit(node)

    # Statements.

    def visit_Return(self, node: ast.Return) -> None:
        """Return the negative, the contrary, the items in another order, or nothing."""
        value = node.value
        if value is None or isinstance(value, ast.Constant):
            self.generic_visit(node)
            return
        if isinstance(value, ast.BinOp) and not _has_text(value):
            self._replace(value, "return", ast.UnaryOp(ast.USub(), copy.deepcopy(value)))
        elif isinstance(value, ast.BoolOp):
            self._replace(value, "return", ast.UnaryOp(ast.Not(), copy.deepcopy(value)))
        elif isinstance(value, ast.Tuple) and len(value.elts) > 1:
            changed = copy.deepcopy(value)
            changed.elts[:2] = changed.elts[1::-1]
            if ast.dump(changed) != ast.dump(value):
                self._replace(value, "return", changed)
        elif not isinstance(value, (ast.Compare, ast.UnaryOp, ast.JoinedStr)):
            self._replace(value, "return", ast.Constant(None))
        self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        """Negate what is assigned if it is arithmetic; remove an assignment whose target has a value before it."""
        names = {part.id for target in node.targets for part in ast.walk(target) if isinstance(part, ast.Name)}
        stored = any(isinstance(target, (ast.Attribute, ast.Subscript)) for target in node.targets)
        if self._functions and (stored or names <= self._assigned[-1]) and "__init__" not in self._within:
            self._add(node, "statement", "pass")
        if isinstance(node.value, ast.BinOp) and not _has_text(node.value) and self._functions:
            self._replace(node.value, "sign", ast.UnaryOp(ast.USub(), copy.deepcopy(node.value)))
        self._assigned[-1] |= names
        if not any(isinstance(target, ast.Name) and target.id == "__all__" for target in node.targets):
            self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        """Remove the statement, and exchange its operator."""
        self._add(node, "statement", "pass")
        other = ARITHMETIC.get(type(node.op))
        if other is not None and not _has_text(node.value):
            changed = copy.deepcopy(node)
            changed.op = other
            self._add(node, "arithmetic", ast.unparse(changed))
        self.generic_visit(node)

    def visit_Expr(self, node: ast.Expr) -> None:
        """Remove a call whose result is not used; a docstring is none."""
        if isinstance(node.value, ast.Call) and self._functions:
            self._add(node, "statement", "pass")
        if not isinstance(node.value, ast.Constant):
            self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        """Do not raise; what the error says is text."""
        self._add(node, "statement", "pass")

    def visit_Continue(self, node: ast.Continue) -> None:
        """Do not go on to the next one."""
        self._add(node, "statement", "pass")

    def visit_Break(self, node: ast.Break) -> None:
        """Do not stop."""
        self._add(node, "statement", "pass")


def _is_text(node: ast.expr) -> bool:
    """Return whether a node is text."""
    return isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes))


def _has_text(node: ast.expr) -> bool:
    """Return whether text is in an expression."""
    return any(
        isinstance(part, ast.JoinedStr) or (isinstance(part, ast.expr) and _is_text(part)) for part in ast.walk(node)
    )


def all_mutants(sources: Iterator[tuple[str, str]]) -> list[Mutant]:
    """Return the mutants of files, given as path and text."""
    return [one for path, source in sources for one in mutants_of(path, source)]
