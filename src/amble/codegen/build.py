"""Casadi functions to native code: C source, compiler, cached library, ``casadi.external``.

``casadi.external`` finds derivatives by name inside the same library (``jac_F``, ``adj1_F``, ``fwd1_F``,
``jac_adj1_F``), so a function that is compiled with them is differentiated in native code as well.
"""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from math import inf
from pathlib import Path

import casadi as ca

from amble.codegen.cache import content_key, fallback_folder, function_key, intact, kept, writable_folder
from amble.codegen.compiler import FLAGS, STOP, Compiler, compiler
from amble.codegen.parts import cut_into_parts
from amble.errors import InputError, UnknownNameError
from amble.names import identifier

logger = logging.getLogger("amble")

LAYOUT = "2"
"""Changes whenever the generated C would change for the same functions."""

PARALLEL = 2

BREAK_EVEN = 15_000
"""Evaluations from which compiling a function takes less time than interpreting it; both grow with its length.
Value, gradient, Jacobian and Hessian of a node of Go2's trot: 0.5 ms interpreted, 0.05 ms compiled; compiling 8 s."""


@dataclass(frozen=True)
class Recipe:
    """Functions that follow from others by a rule, so that a library is found in the cache without building them.

    Attributes:
        seeds: what the functions follow from.
        rule: name of the rule; it must change where ``derive`` would give other functions for the same seeds.
        exports: names of the functions.
        derive: the rule: builds the functions.
    """

    seeds: tuple[ca.Function, ...]
    rule: str
    exports: tuple[str, ...]
    derive: Callable[[], Sequence[ca.Function]]


@dataclass(frozen=True)
class Unit:
    """One C file: its name (for people), its functions, the derivatives of each, or the rule that makes others."""

    name: str
    functions: tuple[ca.Function, ...]
    derivatives: tuple[str, ...] = ()
    recipe: Recipe | None = None

    @property
    def exports(self) -> tuple[str, ...]:
        """Names of the functions that the library is asked for."""
        return self.recipe.exports if self.recipe else tuple(function.name() for function in self.functions)

    def written(self) -> Sequence[ca.Function]:
        """Build the functions that go into the C file."""
        return self.recipe.derive() if self.recipe else self.functions

    def key(self, tool: Compiler) -> str:
        """Content hash of everything that determines the library.

        The functions enter by their serialisation, which takes half the time of the C text and spares building the
        derivatives.
        """
        parts = [LAYOUT, ca.__version__, tool.path, tool.version, *FLAGS, "|", *self.derivatives, "|"]
        parts += [self.recipe.rule, *self.recipe.exports] if self.recipe else []
        return content_key([*parts, *map(function_key, self.functions)])

    def source(self) -> str:
        """C text of the functions and their derivatives."""
        generator = ca.CodeGenerator(f"{identifier(self.name)}.c", {"with_header": False})
        functions: list[ca.Function] = []
        for function in self.written():
            functions += [function, *(derivative(function, prefix) for prefix in self.derivatives)]
        for function in functions:
            generator.add(function)
        return cut_into_parts(str(generator.dump()), functions)


def compiled(function: ca.Function, derivatives: Sequence[str] = ()) -> ca.Function:
    """Compile one function, with the derivatives that will be asked of it.

    Args:
        function: any casadi function that can be turned into C.
        derivatives: prefixes among jac, adj1, fwd1 and their compositions, outermost first: ``jac_adj1`` is the
            Jacobian of the adjoint.

    Returns:
        The same function in native code; the function itself where there is no C compiler (a notice is logged once).

    Raises:
        UnknownNameError: for a derivative that does not exist.
        WorkError: where the compiler fails.
    """
    return compile_many([function], function.name(), derivatives)[function.name()]


def compile_many(
    functions: Sequence[ca.Function], name: str, derivatives: Sequence[str] = ()
) -> dict[str, ca.Function]:
    """Compile several functions into one library; see ``compiled``. Returns function name -> compiled function."""
    return compile_all({name: functions}, {name: derivatives})[name]


def compile_all(
    sources: Mapping[str, Sequence[ca.Function]], derivatives: Mapping[str, Sequence[str]] | None = None
) -> dict[str, dict[str, ca.Function]]:
    """Compile several C files, two at a time; see ``compiled``.

    Args:
        sources: name of the C file -> its functions, whose names must differ within the file.
        derivatives: name of the C file -> derivatives of all its functions; a file that is not named has none.

    Returns:
        Name of the C file -> function name -> compiled function.
    """
    wanted = dict(derivatives or {})
    for name in wanted:
        if name not in sources:
            raise UnknownNameError("C file", name, sources)
    units = [Unit(name, tuple(functions), tuple(wanted.get(name, ()))) for name, functions in sources.items()]
    return _compile(units, compiler())


def compile_recipes(
    recipes: Mapping[str, Recipe], evaluations: Mapping[str, float] | None = None
) -> dict[str, dict[str, ca.Function]]:
    """Compile functions that follow from others by a rule; what is in the cache is not even built.

    Args:
        recipes: name of the C file -> what its functions follow from.
        evaluations: name of the C file -> how often its functions will be evaluated; below ``BREAK_EVEN`` they are
            interpreted unless they are in the cache. A file that is not named is compiled.

    Returns:
        Name of the C file -> function name -> compiled or interpreted function.
    """
    units = [Unit(name, recipe.seeds, recipe=recipe) for name, recipe in recipes.items()]
    tool = compiler()
    if tool is None or not evaluations:
        return _compile(units, tool)
    worth = [unit for unit in units if evaluations.get(unit.name, inf) >= BREAK_EVEN or _known(unit, tool)]
    rest = {unit.name: {f.name(): f for f in unit.written()} for unit in units if unit not in worth}
    return {**rest, **_compile(worth, tool)}


def _known(unit: Unit, tool: Compiler) -> bool:
    try:
        return intact(_place(unit, tool))
    except OSError:
        return False


def _compile(units: Sequence[Unit], tool: Compiler | None) -> dict[str, dict[str, ca.Function]]:
    for unit in units:
        _check(unit)
    if tool is None:
        return _interpreted(units, "no C compiler found")
    try:
        libraries = _libraries(units, tool)
    except OSError as error:
        return _interpreted(units, f"compiled code cannot be stored ({error.strerror or error})")
    return {
        unit.name: {name: ca.external(name, str(library)) for name in unit.exports}
        for unit, library in zip(units, libraries, strict=True)
    }


def derivative(function: ca.Function, prefix: str) -> ca.Function:
    """Derive the function that casadi names ``prefix_function``."""
    for step in reversed(prefix.split("_")):
        if step == "jac":
            function = function.jacobian()
        elif step == "adj1":
            function = function.reverse(1)
        elif step == "fwd1":
            function = function.forward(1)
        else:
            raise UnknownNameError("derivative", prefix, ["jac", "adj1", "fwd1", "compositions such as jac_adj1"])
    return function


def _check(unit: Unit) -> None:
    names = unit.exports
    if len(set(names)) != len(names):
        raise InputError(f"functions of '{unit.name}' share a name: {', '.join(names)}")
    for prefix in unit.derivatives:
        derivative(_IDENTITY, prefix)


def _libraries(units: Sequence[Unit], tool: Compiler) -> list[Path]:
    paths = [_place(unit, tool) for unit in units]
    missing = {path: unit for path, unit in zip(paths, units, strict=True) if not intact(path)}
    if not missing:
        return paths
    texts = {path: unit.source() for path, unit in missing.items()}
    with ThreadPoolExecutor(max_workers=PARALLEL) as pool:
        names = [unit.exports for unit in missing.values()]
        try:
            built = dict(zip(texts, pool.map(_build, texts, texts.values(), names, repeat(tool)), strict=True))
        except BaseException:  # Ctrl-C, or a failure: what the other threads compile is not waited for
            STOP.set()
            pool.shutdown(cancel_futures=True)
            raise
        finally:
            STOP.clear()
    return [built.get(path, path) for path in paths]


def _place(unit: Unit, tool: Compiler) -> Path:
    return writable_folder() / f"{identifier(unit.name)}-{unit.key(tool)}.so"


def _build(library: Path, text: str, names: Sequence[str], tool: Compiler) -> Path:
    """Compile into the library's folder; into a temporary one where the disk is full. Returns where it ended up."""
    try:
        return _build_in(library, text, names, tool)
    except OSError as error:
        folder = fallback_folder(f"{library.parent}: {error.strerror or error}")
        return _build_in(folder / library.name, text, names, tool)


def _build_in(library: Path, text: str, names: Sequence[str], tool: Compiler) -> Path:
    def build(output: Path) -> None:
        logger.info("compiling %s ...", output.stem)
        source = output.with_suffix(".c")
        source.write_text(text)
        tool.build(source, output, names=names)

    return kept(library, build)


def _interpreted(units: Sequence[Unit], reason: str) -> dict[str, dict[str, ca.Function]]:
    _notice_interpreted(reason)
    return {unit.name: {f.name(): f for f in unit.written()} for unit in units}


@functools.cache
def _notice_interpreted(reason: str) -> None:
    logger.warning("%s: functions are interpreted, which is about ten times slower", reason)


_SYMBOL = ca.SX.sym("x")
_IDENTITY = ca.Function("identity", [_SYMBOL], [_SYMBOL])
