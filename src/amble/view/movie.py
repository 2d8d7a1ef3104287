"""A replay as a film: MuJoCo's renderer draws the frames, the program ffmpeg encodes them as MP4.

The scene is the replay's own: every link is a body that is put where the replay says, so no physics is involved.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError, WorkError, shown
from amble.io.storage import replacing
from amble.optional import require
from amble.progress import Progress, ProgressReport, silent
from amble.types import IntegerVector, Matrix, Vector
from amble.view.page import ReplayPage
from amble.view.replay import Replay
from amble.view.shapes import BOX

WIDTH, HEIGHT, RATE = 960, 600, 30
"""Pixels of a film, and frames a second."""

SLOWER = 2.0
"""Duration of a film over that of its motion, as a replay page begins."""

LINK, BASE, FOOT, FORCE, MASS = (
    (0.56, 0.64, 0.74, 1.0),
    (0.36, 0.46, 0.59, 1.0),
    (0.0, 0.45, 0.7, 1.0),
    (0.84, 0.37, 0.0, 1.0),
    (0.8, 0.47, 0.65, 1.0),
)
"""Colours, as on the page."""


def write_movie(page: ReplayPage, path: str | Path, progress: Progress | None = None) -> Path:
    """Write the motions of a page as an MP4 film at half speed, two of them side by side.

    Args:
        page: one or two motions.
        path: where to write it, whole or not at all.
        progress: called every second of the film.

    Raises:
        MissingExtraError: mujoco is not installed.
        InputError: the ground is not level, or the place cannot be written.
        WorkError: MuJoCo's renderer cannot draw here, or there is no ffmpeg, or it fails.
    """
    require("mujoco", "mujoco", "films")
    encoder = shutil.which("ffmpeg")
    if encoder is None:
        raise WorkError("a film is encoded by the program ffmpeg, which was not found; --html needs none")
    for replay in page.replays:
        if np.ptp(replay.ground.heights) > 0.0:
            raise InputError(f"a film shows level ground, and '{replay.label}' walks on another; --html shows any")
    notify, width = progress or silent, WIDTH // len(page.replays)
    scenes = [_Scene(replay, width - width % 2) for replay in page.replays]
    longest = max(float(replay.times[-1]) for replay in page.replays)
    count = max(1, round(SLOWER * longest * RATE))
    size = f"{sum(scene.width for scene in scenes)}x{HEIGHT}"
    with replacing(Path(path)) as temporary:
        raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(RATE), "-i", "-")
        coded = ("-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4")
        command = (encoder, "-y", "-loglevel", "error", *raw, *coded, str(temporary))
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as running:
            try:
                for number in range(count):
                    if number % RATE == 0:
                        notify(ProgressReport(what="drawing frames", done=number, of=count))
                    pictures = [scene.drawn(number / RATE / SLOWER) for scene in scenes]
                    running.stdin.write(np.ascontiguousarray(np.hstack(pictures)).tobytes())  # type: ignore[union-attr]
                said = running.communicate()[1]
            except BrokenPipeError:
                said = running.stderr.read() if running.stderr else b""
        if running.returncode != 0:
            raise WorkError(f"ffmpeg failed: {shown(said.decode('utf-8', 'replace'), 300)}")
    return Path(path)


def _engine() -> Any:
    """Import mujoco so that it draws into memory where there is no display."""
    require("mujoco", "mujoco", "films")
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")  # read when mujoco is imported
    import mujoco

    return mujoco


class _Scene:
    """One motion in MuJoCo's renderer."""

    def __init__(self, replay: Replay, width: int) -> None:
        mujoco = _engine()
        self.mujoco, self.replay, self.width = mujoco, replay, width
        self.model = _model(mujoco, replay, width)
        self.data = mujoco.MjData(self.model)
        self.camera = mujoco.MjvCamera()
        length = replay.robot.leg_length
        self.camera.azimuth, self.camera.elevation, self.camera.distance = 120.0, -14.0, 3.2 * length
        try:
            self.renderer = mujoco.Renderer(self.model, HEIGHT, width)
        except Exception as error:  # whatever the drivers raise
            raise WorkError(
                f"MuJoCo's renderer cannot draw here: {shown(str(error), 200)}; set MUJOCO_GL to egl, osmesa or glfw"
            ) from error

    def drawn(self, time: float) -> IntegerVector:
        """The picture at a time, (height, width, 3); the last frame stays after the end."""
        replay, mujoco = self.replay, self.mujoco
        frame = int(np.clip(np.searchsorted(replay.times, time), 0, len(replay.times) - 1))
        self.data.mocap_pos[:] = replay.links[frame, :, :3]
        self.data.mocap_quat[:] = replay.links[frame][:, [6, 3, 4, 5]]
        mujoco.mj_forward(self.model, self.data)
        middle = replay.center[frame].copy()
        middle[2] = 0.5 * middle[2]
        self.camera.lookat[:] = middle
        self.renderer.update_scene(self.data, self.camera)
        length, weight = replay.robot.leg_length, replay.robot.mass * replay.robot.gravity
        for foot in np.flatnonzero(replay.stance[frame]):
            start, force = replay.feet[frame, foot], replay.forces[frame, foot]
            self._arrow(start, start + force * 1.2 * length / weight, 0.02 * length)
            self._ball(start, 0.035 * length, FOOT)
        self._ball(replay.center[frame], 0.04 * length, MASS)
        return np.asarray(self.renderer.render())

    def _more(self, kind: Any, colour: tuple[float, float, float, float], size: Vector, place: Vector) -> Any:
        scene = self.renderer.scene
        scene.ngeom += 1
        geom = scene.geoms[scene.ngeom - 1]
        self.mujoco.mjv_initGeom(geom, kind, size, place, np.eye(3).ravel(), np.array(colour, dtype=np.float32))
        return geom

    def _ball(self, place: Vector, radius: float, colour: tuple[float, float, float, float]) -> None:
        self._more(self.mujoco.mjtGeom.mjGEOM_SPHERE, colour, np.full(3, radius), np.asarray(place, dtype=np.float64))

    def _arrow(self, start: Vector, end: Vector, width: float) -> None:
        kind = self.mujoco.mjtGeom.mjGEOM_ARROW
        geom = self._more(kind, FORCE, np.zeros(3), np.zeros(3))
        self.mujoco.mjv_connector(geom, kind, width, np.array(start), np.array(end))


def _model(mujoco: Any, replay: Replay, width: int) -> Any:
    """A scene of the ground and a body for every link, which the data move."""
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, HEIGHT
    length, height = replay.robot.leg_length, float(replay.ground.heights.flat[0])
    spec.add_texture(
        name="cells", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.93, 0.94, 0.96], rgb2=[0.86, 0.88, 0.91], width=256, height=256,
    )  # fmt: skip
    cells = spec.add_material(name="cells", texrepeat=[1.0 / length, 1.0 / length], texuniform=True)
    cells.textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = "cells"
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=[0.95, 0.96, 0.98], rgb2=[0.95, 0.96, 0.98], width=16, height=96,
    )  # fmt: skip
    world = spec.worldbody
    world.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, pos=[0.0, 0.0, height], size=[0.0, 0.0, 1.0], material="cells"
    )  # fmt: skip
    world.add_light(
        pos=[0.0, 0.0, 10.0 * length], dir=[-0.3, 0.2, -1.0], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        castshadow=False,
    )  # fmt: skip
    bodies = [world.add_body(name=f"link {number}", mocap=True) for number in range(len(replay.robot.links))]
    meshed = {mesh.link for mesh in replay.meshes}
    for mesh in replay.meshes:
        name = f"mesh {mesh.link}"
        _add_mesh(mujoco, spec, name, mesh.vertices, mesh.faces)
        bodies[mesh.link].add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, rgba=LINK if mesh.link else BASE, contype=0, conaffinity=0
        )
    for shape in replay.shapes:
        if shape.link in meshed:
            continue
        size, middle = 0.5 * np.abs(shape.second - shape.first), 0.5 * (shape.first + shape.second)
        place: dict[str, Any]
        if shape.kind == BOX:
            kind, place = mujoco.mjtGeom.mjGEOM_BOX, {"pos": middle, "size": size}
        elif np.any(size > 1e-9):
            kind, place = mujoco.mjtGeom.mjGEOM_CAPSULE, {
                "fromto": [*shape.first, *shape.second], "size": [shape.radius, 0.0, 0.0],
            }  # fmt: skip
        else:
            kind, place = mujoco.mjtGeom.mjGEOM_SPHERE, {"pos": middle, "size": [shape.radius, 0.0, 0.0]}
        bodies[shape.link].add_geom(type=kind, rgba=LINK if shape.link else BASE, contype=0, conaffinity=0, **place)
    return spec.compile()


def _add_mesh(mujoco: Any, spec: Any, name: str, vertices: Matrix, faces: IntegerVector) -> None:
    mesh = spec.add_mesh(name=name)
    mesh.uservert, mesh.userface = np.ravel(vertices).tolist(), np.ravel(faces).astype(int).tolist()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # a look encloses no volume
