"""Compiled functions of the host as MicroPython: the same source, operation by operation, on lists and arrays.

A tick reads rows of numbers by name, and calls functions that do. What is a row is followed from the tick's arguments
through all calls, so that a name becomes a place. Whatever has no form on a board is an error where it is translated.
"""

from __future__ import annotations

import ast
import copy
import inspect
import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from musclewire.compiled import row_in
from musclewire.errors import CallerError

# What MicroPython has under the same name.
BUILT_IN = frozenset({"abs", "bool", "float", "int", "len", "max", "min", "range"})
# Arrays that a tick makes: each becomes a list of one number, so many times.
FILLED = {np.zeros: 0.0, np.empty: 0.0, np.ones: 1.0}


# A table of several rows, without a copy of its numbers.
ROWS_OF = """def rows_of(table, count):
    size = len(table) // count
    return [table[row * size : (row + 1) * size] for row in range(count)]"""


class Each(NamedTuple):
    """An array of rows."""

    layout: np.dtype[Any]


class UntranslatableError(CallerError):
    """What a board cannot do; with function and line."""


# What an expression is, as far as it matters: a row, an array of rows, a tuple of a class with names, anything else.
Layout = np.dtype[Any] | Each | type | None


@dataclass
class Translation:
    """Functions that are translated, and those that they call; ``source`` is all of it."""

    functions: dict[Any, str] = field(default_factory=dict)
    classes: dict[type, list[Layout]] = field(default_factory=dict)
    arguments: dict[tuple[Any, int], Layout] = field(default_factory=dict)
    constants: dict[str, Any] = field(default_factory=dict)
    waiting: list[Any] = field(default_factory=list)
    written: list[str] = field(default_factory=list)

    def add(self, function: Callable[..., Any], rows: Mapping[str, Layout] | None = None) -> None:
        """Translate a function, with what is a row among its arguments, and whatever it calls."""
        for index, name in enumerate(inspect.signature(plain(function)).parameters):
            self.arguments[function, index] = (rows or {}).get(name)
        self.name_of(function)
        while self.waiting:
            self.written.append(_Function(self, self.waiting.pop(0)).source())

    def name_of(self, function: Any) -> str:
        """Return what a function is called on the board; a new one is translated later."""
        if function not in self.functions:
            name = plain(function).__name__
            if name in self.functions.values():
                name = f"{name}_of_{plain(function).__module__.rpartition('.')[2].lstrip('_')}"
            self.functions[function] = name
            self.waiting.append(function)
        return self.functions[function]

    @property
    def source(self) -> str:
        """All functions as the text of one module."""
        classes = [f'{kind.__name__} = namedtuple("{kind.__name__}", {kind._fields!r})' for kind in self.classes]  # type: ignore[attr-defined]
        constants = [f"{name} = {value!r}" for name, value in self.constants.items()]
        head = ["import math", "from collections import namedtuple", "", *classes, *constants]
        return "\n\n\n".join(["\n".join(head), ROWS_OF, *self.written]) + "\n"


def plain(function: Any) -> Callable[..., Any]:
    """Return the Python function of a compiled one."""
    found: Callable[..., Any] = getattr(function, "py_func", function)
    return found


class _Function(ast.NodeTransformer):
    """One function on its way to the board."""

    def __init__(self, translation: Translation, function: Any) -> None:
        self._all, self._function = translation, function
        self._python = plain(function)
        self._globals = self._python.__globals__
        self._layouts: dict[str, Layout] = {}
        self._locals: set[str] = set()

    def source(self) -> str:
        """Return its text, without docstring and annotations."""
        tree = ast.parse(textwrap.dedent(inspect.getsource(self._python))).body[0]
        assert isinstance(tree, ast.FunctionDef)
        names = [argument.arg for argument in tree.args.args]
        stored = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
        self._locals = {*names, *stored}
        for index, argument in enumerate(tree.args.args):
            kind = self._named_tuple(argument.annotation)
            self._layouts[argument.arg] = kind or self._all.arguments.get((self._function, index))
            argument.annotation = None
        body = tree.body[1:] if ast.get_docstring(tree) is not None else tree.body
        tree.body = [found for statement in body for found in _as_list(self.visit(statement))]
        tree.decorator_list, tree.returns, tree.name = [], None, self._all.functions[self._function]
        return ast.unparse(ast.fix_missing_locations(tree))

    def _named_tuple(self, annotation: ast.expr | None) -> type | None:
        kind = self._globals.get(annotation.id) if isinstance(annotation, ast.Name) else None
        return self._class(kind)

    def _class(self, kind: Any) -> type | None:
        """Return a class of tuples with names, None for anything else."""
        if not (isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")):
            return None
        self._all.classes.setdefault(kind, [None] * len(kind._fields))
        return kind

    def _refuse(self, node: ast.AST, what: str) -> UntranslatableError:
        place = f"{self._python.__module__}.{self._python.__name__}, line {getattr(node, 'lineno', 0)} of it"
        return UntranslatableError(f"{place}: {what} has no form in MicroPython; write it with numbers, lists and math")

    def _global(self, node: ast.expr) -> Any:
        """Return what a name means outside the function, None for one of its own."""
        if isinstance(node, ast.Name) and node.id not in self._locals:
            return self._globals.get(node.id)
        if isinstance(node, ast.Attribute) and self._global(node.value) in (np, math):
            return getattr(self._global(node.value), node.attr, None)
        return None

    def _layout_of(self, node: ast.expr) -> Layout:
        """Return what an expression is, before it is translated."""
        if isinstance(node, ast.Name):
            return self._layouts.get(node.id)
        if isinstance(node, ast.Attribute):
            kind = self._layout_of(node.value)
            return self._all.classes[kind][kind._fields.index(node.attr)] if isinstance(kind, type) else None  # type: ignore[attr-defined]
        if isinstance(node, ast.Subscript):
            several = self._layout_of(node.value)
            return several.layout if isinstance(several, Each) else None
        if isinstance(node, ast.Call):
            called = self._global(node.func)
            if called is row_in:
                layout: Layout = np.dtype(self._global(node.args[1]))
                return layout
            return self._class(called) or self._returned(called)
        return None

    def _returned(self, called: Any) -> type | None:
        annotation = getattr(plain(called), "__annotations__", {}).get("return")
        return self._class(plain(called).__globals__.get(annotation)) if isinstance(annotation, str) else None

    def _bind(self, target: ast.expr, value: ast.expr) -> None:
        """Remember what an assignment makes of its targets."""
        if isinstance(target, ast.Name):
            self._layouts[target.id] = self._layout_of(value)
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for one, other in zip(target.elts, value.elts, strict=True):
                self._bind(one, other)
        elif isinstance(target, ast.Tuple) and isinstance(kind := self._layout_of(value), type):
            for one, layout in zip(target.elts, self._all.classes[kind], strict=True):
                if isinstance(one, ast.Name):
                    self._layouts[one.id] = layout

    def _hand_over(self, node: ast.Call, known: list[Layout] | None, key: Callable[[int], Any]) -> None:
        """Remember what is handed over to a function or to a tuple; another row in the same place is an error."""
        for index, argument in enumerate(node.args):
            layout = self._layout_of(argument)
            if layout is None or isinstance(layout, type):
                continue
            before = known[index] if known is not None else self._all.arguments.get(key(index))
            if before is not None and before != layout:
                raise self._refuse(node, "a row of another kind than in an earlier call")
            if known is not None:
                known[index] = layout
            else:
                self._all.arguments[key(index)] = layout

    def visit_Assign(self, node: ast.Assign) -> Any:
        for target in node.targets:
            self._bind(target, node.value)
        first = node.targets[0]
        if isinstance(first, ast.Subscript) and isinstance(first.slice, ast.Slice):
            # A slice of a list takes no single number.
            filled = [self.visit(target.value) for target in node.targets if isinstance(target, ast.Subscript)]
            value = self.visit(node.value)
            index = ast.Name("place_", ast.Load())
            body: list[ast.stmt] = [ast.Assign([ast.Subscript(each, index, ast.Store())], value) for each in filled]
            count = ast.Call(ast.Name("len", ast.Load()), [filled[0]], [])
            every = ast.Call(ast.Name("range", ast.Load()), [count], [])
            return ast.For(ast.Name("place_", ast.Store()), every, body, [])
        return self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> Any:
        layout = self._layout_of(node.value)
        if isinstance(layout, np.dtype):
            return self._place(node, layout, node.attr)
        if node.attr == "size":
            return ast.Call(ast.Name("len", ast.Load()), [self.visit(node.value)], [])
        if isinstance(layout, type) or (isinstance(node.value, ast.Name) and node.value.id == "math"):
            return node if isinstance(node.value, ast.Name) else self.generic_visit(node)
        raise self._refuse(node, f"'{ast.unparse(node)}'")

    def visit_Subscript(self, node: ast.Subscript) -> Any:
        layout = self._layout_of(node.value)
        if isinstance(layout, np.dtype) and isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str):
            return self._place(node, layout, node.slice.value)
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            return ast.Call(ast.Name("len", ast.Load()), [self.visit(node.value.value)], [])
        if isinstance(node.slice, ast.Tuple):
            value = self.visit(node.value)
            for index in node.slice.elts:
                value = ast.Subscript(value, self.visit(index), node.ctx)
            return value
        return self.generic_visit(node)

    def _place(self, node: Any, layout: np.dtype[Any], name: str) -> ast.Subscript:
        if name not in (layout.names or ()):
            raise self._refuse(node, f"'{name}', which its row has not,")
        return ast.Subscript(self.visit(node.value), ast.Constant((layout.names or ()).index(name)), node.ctx)

    def visit_Call(self, node: ast.Call) -> Any:
        called = self._global(node.func)
        if called is row_in:
            return self.visit(node.args[0])
        if called in FILLED:
            return ast.BinOp(ast.List([ast.Constant(FILLED[called])], ast.Load()), ast.Mult(), self.visit(node.args[0]))
        if isinstance(node.func, ast.Attribute) and node.func.attr == "reshape":
            return ast.Call(
                ast.Name("rows_of", ast.Load()), [self.visit(node.func.value), self.visit(node.args[0])], []
            )
        if (kind := self._class(called)) is not None:
            self._hand_over(node, self._all.classes[kind], lambda index: index)
        elif called is not None and called in vars(math).values():
            node.func = ast.Attribute(ast.Name("math", ast.Load()), plain(called).__name__, ast.Load())
        elif callable(called):
            if not inspect.isfunction(plain(called)):
                raise self._refuse(node, f"'{ast.unparse(node.func)}'")
            self._hand_over(node, None, lambda index: (called, index))
            node.func = ast.Name(self._all.name_of(called), ast.Load())
            node.args = [self.visit(argument) for argument in node.args]
            return node
        return self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> Any:
        """Write a square as the product that Numba makes of it: a chip's power may differ in the last digit."""
        if not isinstance(node.op, ast.Pow):
            return self.generic_visit(node)
        if not (isinstance(node.right, ast.Constant) and node.right.value == 2):
            raise self._refuse(node, "a power other than 2")
        return ast.BinOp(self.visit(copy.deepcopy(node.left)), ast.Mult(), self.visit(node.left))

    def visit_Name(self, node: ast.Name) -> Any:
        if node.id in self._locals or node.id in BUILT_IN or node.id in ("math", "place_"):
            return node
        value = self._globals.get(node.id)
        if isinstance(value, bool | int | float):
            return ast.Constant(int(value) if isinstance(value, int) else float(value))
        if isinstance(value, tuple) and not hasattr(value, "_fields"):
            self._all.constants[node.id] = value
            return node
        if self._class(value) is not None:
            return node
        raise self._refuse(node, f"'{node.id}'")


def _as_list(found: Any) -> Sequence[ast.stmt]:
    return found if isinstance(found, list) else [found]
