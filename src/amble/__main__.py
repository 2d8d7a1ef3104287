"""``python -m amble``."""

from amble.cli import main

main()
