# SPDX-License-Identifier: MIT
"""Last stage: LNodes -> C++ templated on the scalar type T (double, or a vector of doubles with one cell per lane)."""

import ffcx.codegeneration.lnodes as L
import numpy as np

_TYPES = {L.DataType.SCALAR: "T", L.DataType.REAL: "double", L.DataType.INT: "int", L.DataType.BOOL: "bool"}

_MATH = {
    "power": "pow",
    "ln": "log",
    "atan_2": "atan2",
    "min_value": "min",
    "max_value": "max",
}


class Unrolled(L.ForRange):
    """A short loop that the compiler is told to unroll."""


class LocalSolve(L.Statement):
    """Local equations at a point, solved by kernels/LocalNewton.h.

    Args:
        name: of the solution that is declared; its values are <name>_x.
        start: first values of the unknowns. scale: size of the residual's terms.
        equations: statements that fill the arrays `residual` and `jacobian` (rows first) from the array `iterate`.
        condition: None, or a condition; where it holds in no lane, `other` stands for `equations`.
        error: None, or what the start may differ from the solution by (only where there is no condition).
        declared: whether an array of the values has been declared, which is assigned.
    """

    def __init__(self, name, start, scale, equations, condition=None, other=None, declared=False, error=None):
        self.name, self.start, self.scale, self.equations = name, start, scale, equations
        self.condition, self.other, self.declared, self.error = condition, other, declared, error


class Rounded(L.LExprOperator):
    """A value that is rounded before it is added to anything (kernels/simd.h)."""

    precedence = L.PRECEDENCE.HIGHEST

    def __init__(self, arg):
        self.arg, self.dtype = arg, L.DataType.SCALAR


class AnyLane(L.Statement):
    """Statements that are executed if a condition holds in any lane; what they declare ends with them."""

    def __init__(self, condition, body):
        self.condition, self.body = condition, body


class StoreHistory(L.Statement):
    """New internal variables of a point are written, in place where any of them differs from the old one.

    Args:
        values: triples of a new value (a symbol), the old one, and the place of the new one.
    """

    def __init__(self, values):
        self.values = values


class Apart(L.Statement):
    """Statements of a kernel that does not overwrite what it reads."""

    def __init__(self, body):
        self.body = body


class Text(L.Statement):
    """A statement that is written as it stands."""

    def __init__(self, text):
        self.text = text


class CxxFormatter:
    """Formats LNodes as C++."""

    def __call__(self, node):
        return getattr(self, "_" + type(node).__name__)(node)

    @staticmethod
    def _number(x):
        if isinstance(x, (int, np.integer)):
            return str(int(x))
        text = repr(float(x))
        return text if any(ch in text for ch in ".en") else text + ".0"

    def _values(self, values):
        if values.ndim == 1:
            return "{" + ", ".join(self._number(v) for v in values) + "}"
        return "{" + ",\n   ".join(self._values(v) for v in values) + "}"

    def _StatementList(self, s):
        return "".join(self(x) for x in s.statements)

    def _Section(self, s):
        body = "".join(self(x) for x in list(s.declarations) + list(s.statements))
        return f"\n// {s.name}\n{body}"

    def _LocalSolve(self, s):
        count = len(s.start)
        start = ", ".join(self(x) if _is_scalar(x) else f"splat<T>({self(x)})" for x in s.start)
        scale = self(s.scale) if _is_scalar(s.scale) else f"splat<T>({self(s.scale)})"

        error = "" if s.error is None else f" {self(s.error)},"

        def solution(equations):
            body = "".join(f"  {line}\n" for x in equations for line in self(x).splitlines())
            return (
                f"local_newton<T, {count}>({s.name}_start, {scale},{error}\n"
                f"  [&](const T* __restrict iterate, T* __restrict residual, T* __restrict jacobian)\n{{\n{body}}})"
            )

        value = solution(s.equations)
        if s.condition is not None:
            value = f"not any_lane({self(s.condition)})\n  ? {solution(s.other)}\n  : {value}"
        values = f"const T (&{s.name}_x)[{count}] = {s.name}.x;\n"
        if s.declared:
            values = "".join(f"{s.name}_x[{i}] = {s.name}.x[{i}];\n" for i in range(count))
        return f"const T {s.name}_start[{count}] = {{{start}}};\nconst auto {s.name} = {value};\n{values}"

    def _AnyLane(self, s):
        body = "".join(f"  {line}\n" for x in s.body for line in self(x).splitlines())
        return f"if (any_lane({self(s.condition)}))\n{{\n{body}}}\n"

    def _StoreHistory(self, s):
        differ = " |\n    ".join(f"({self(new)} != {self(old)})" for new, old, _ in s.values)
        stored = "".join(f"  {self(place)} = {self(new)};\n" for new, _, place in s.values)
        condition = f"bool changed = true;\nif constexpr (in_place)\n  changed = any_lane({differ});\n"
        return f"{condition}if (changed)\n{{\n{stored}}}\n"

    def _Apart(self, s):
        body = "".join(f"  {self(a)}" for a in s.body)
        return f"if constexpr (not in_place)\n{{\n{body}}}\n"

    def _Text(self, t):
        return f"{t.text}\n"

    def _Comment(self, c):
        return f"// {c.comment}\n"

    def _Statement(self, s):
        return self(s.expr)

    def _ArrayDecl(self, a):
        sizes = "".join(f"[{n}]" for n in a.sizes)
        name, kind = self(a.symbol), _TYPES[a.symbol.dtype]
        if a.values is None:
            return f"{kind} {name}{sizes};\n"
        if not a.const:  # our generator only zeroes arrays
            return f"{kind} {name}{sizes};\nclear<{kind}>({name});\n"
        return f"static constexpr {kind} {name}{sizes}\n  = {self._values(np.asarray(a.values))};\n"

    def _VariableDecl(self, v):
        kind = _TYPES[v.symbol.dtype]
        if kind == "T" and not _is_scalar(v.value):
            return f"const T {self(v.symbol)} = splat<T>({self(v.value)});\n"
        return f"const {kind} {self(v.symbol)} = {self(v.value)};\n"

    def _assign(self, a):
        right = self(a.rhs)
        if a.op == "=" and a.lhs.dtype == L.DataType.SCALAR and not _is_scalar(a.rhs):
            right = f"splat<T>({right})"
        return f"{self(a.lhs)} {a.op} {right};\n"

    _Assign = _AssignAdd = _AssignSub = _assign

    def _ForRange(self, r, pragma=""):
        i = self(r.index)
        body = "".join(f"  {line}\n" for line in self(r.body).splitlines())
        return f"{pragma}for (int {i} = {self(r.begin)}; {i} < {self(r.end)}; ++{i})\n{{\n{body}}}\n"

    def _Unrolled(self, r):
        return self._ForRange(r, "#pragma GCC unroll 32\n")

    def _binary(self, e):
        left, right = self(e.lhs), self(e.rhs)
        if _precedence(e.lhs) > e.precedence:
            left = f"({left})"
        if _precedence(e.rhs) >= e.precedence:
            right = f"({right})"
        return f"{left} {e.op} {right}"

    _Add = _Sub = _Mul = _Div = _binary
    _LT = _LE = _GT = _GE = _EQ = _NE = _binary

    def _logic(self, e):
        return f"({self(e.lhs)}) {e.op} ({self(e.rhs)})"

    _And = _Or = _logic

    def _Not(self, e):
        return f"!({self(e.arg)})"

    def _Neg(self, e):
        arg = self(e.arg)
        return f"-({arg})" if e.arg.precedence >= e.precedence else f"-{arg}"

    def _Rounded(self, e):
        return f"rounded({self(e.arg)})"

    def _Sum(self, e):
        return " + ".join(self(a) if a.precedence < e.precedence else f"({self(a)})" for a in e.args)

    def _Product(self, e):
        return " * ".join(self(a) if a.precedence < e.precedence else f"({self(a)})" for a in e.args)

    def _Conditional(self, e):
        kind = _TYPES[e.dtype]
        return f"select<{kind}>({self(e.condition)}, {self(e.true)}, {self(e.false)})"

    def _MathFunction(self, e):
        kind = _TYPES[e.dtype]
        args = ", ".join(f"splat<{kind}>({self(a)})" if kind == "T" and not _is_scalar(a) else self(a) for a in e.args)
        name = _MATH.get(e.function, e.function)
        if e.function == "power" and isinstance(e.args[1], L.LiteralFloat):
            thirds = 3 * float(e.args[1].value)
            if abs(thirds - round(thirds)) < 1e-15 and round(thirds) in (1, 2, -1, -2):
                return f"math::third_power<{round(thirds)}>({self(e.args[0])})"
            return f"math::{name}({self(e.args[0])}, {self(e.args[1])})"
        return f"math::{name}({args})"

    def _ArrayAccess(self, a):
        return self(a.array) + "".join(f"[{self(i)}]" for i in a.indices)

    def _MultiIndex(self, m):
        return self(m.global_index)

    def _Symbol(self, s):
        return s.name

    def _LiteralFloat(self, x):
        text = self._number(float(x.value))
        return f"({text})" if text.startswith("-") else text

    def _LiteralInt(self, x):
        return str(int(x.value))


def _precedence(e):
    """Of the text that is written: a point number in two or three directions is a sum, which FFCx counts as a
    symbol."""
    return e.global_index.precedence if isinstance(e, L.MultiIndex) else e.precedence


def _is_scalar(e):
    """Does the expression have type T (rather than double, which T would not be initialised from)?"""
    if isinstance(e, (L.Symbol, L.ArrayAccess, L.MathFunction, L.Conditional)):
        return e.dtype == L.DataType.SCALAR
    if isinstance(e, L.Neg):
        return _is_scalar(e.arg)
    if isinstance(e, L.BinOp):
        return _is_scalar(e.lhs) or _is_scalar(e.rhs)
    if isinstance(e, L.NaryOp):
        return any(_is_scalar(a) for a in e.args)
    return False
