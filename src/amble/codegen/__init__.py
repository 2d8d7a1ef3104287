"""Casadi functions to cached native code; interpreted where there is no C compiler."""

from amble.codegen.build import Recipe, compile_all, compile_many, compile_recipes, compiled
from amble.codegen.cache import cache_folder
from amble.codegen.compiler import Compiler, compiler

__all__ = [
    "Compiler",
    "Recipe",
    "cache_folder",
    "compile_all",
    "compile_many",
    "compile_recipes",
    "compiled",
    "compiler",
]
