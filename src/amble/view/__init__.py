"""Replays: a motion as one page that moves, without network or server."""

from amble.view.page import ReplayPage, replay_fragment
from amble.view.replay import Replay, replay_of_samples
from amble.view.show import replay

__all__ = ["Replay", "ReplayPage", "replay", "replay_fragment", "replay_of_samples"]
