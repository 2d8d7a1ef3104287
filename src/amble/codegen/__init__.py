"""Casadi functions to cached native code; interpreted where there is no C compiler."""

from amble.codegen.build import compile_all, compile_many, compiled
from amble.codegen.cache import cache_folder
from amble.codegen.compiler import Compiler, compiler

__all__ = ["Compiler", "cache_folder", "compile_all", "compile_many", "compiled", "compiler"]
