"""Safe writing: an interrupted command leaves the last good file or folder, never half of one."""

from amble.io.storage.files import atomic_write, check_replaceable, dumps, replacing, replacing_folder
from amble.io.storage.places import (
    check_file,
    check_folder,
    confined,
    file_at,
    folder_at,
    kept_workplace,
    sweep,
    workplace,
)

__all__ = [
    "atomic_write",
    "check_file",
    "check_folder",
    "check_replaceable",
    "confined",
    "dumps",
    "file_at",
    "folder_at",
    "kept_workplace",
    "replacing",
    "replacing_folder",
    "sweep",
    "workplace",
]
