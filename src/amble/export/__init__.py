"""The controller of a gait as self-contained C99, and the closed loop that runs it."""

from amble.export.closed_loop import exported_loop
from amble.export.controller import Exported, export_controller, export_schedule

__all__ = ["Exported", "export_controller", "export_schedule", "exported_loop"]
