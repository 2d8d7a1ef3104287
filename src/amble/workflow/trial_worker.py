"""A process that does every n-th missing piece of a folder's trials: ``python -m amble.workflow.trial_worker``.

Arguments: folder, engine, number of all trials, number of this worker, number of workers. It ends when its pieces are
done, or when the process that started it is gone.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from amble.errors import AmbleError
from amble.workflow.push_trials import PIECE, TrialFolder, engine_named, run_trials


def work(place: Path, engine: str, trials: int, number: int, workers: int) -> None:
    """Do the pieces whose place among all, modulo the number of workers, is that of this worker."""
    parent, folder = os.getppid(), TrialFolder.opened(place)
    mine = [piece for piece in folder.missing(engine, trials) if piece.start // PIECE % workers == number]
    run = engine_named(engine)(folder.gait, folder.settings) if mine else None
    for piece in mine:
        if run is None or os.getppid() != parent:
            return
        folder.write(engine, piece, list(run_trials(folder.gait, folder.settings, run, piece)))


if __name__ == "__main__":
    try:
        work(Path(sys.argv[1]), sys.argv[2], *map(int, sys.argv[3:6]))
    except AmbleError as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:  # the process that started this one tells of it
        sys.exit(130)
