"""A process in which MuJoCo compiles one MJCF file: it may hang, take all memory, end the process, or read other files.

Run by ``mjcf`` as a script, never imported: it needs numpy and mujoco alone. Standard input holds the file, then the
files that it may use, one after the other; once MuJoCo is there, no other file can be opened. What was found goes to
standard output as JSON: "refused" with a reason, "needs" with the mesh files that are missing, or the compiled model.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import warnings
from typing import Any

ARRAYS = (
    *("body_parentid", "body_rootid", "body_jntadr", "body_jntnum", "body_mass", "body_ipos", "body_iquat"),
    *("body_inertia", "body_pos", "body_quat", "body_gravcomp", "qpos0", "jnt_type", "jnt_pos", "jnt_axis"),
    *("jnt_dofadr", "jnt_qposadr", "jnt_limited", "jnt_range", "jnt_actfrclimited", "jnt_actfrcrange"),
    *("jnt_stiffness", "dof_armature", "dof_damping", "dof_frictionloss", "actuator_trntype", "actuator_trnid"),
    *("actuator_gear", "actuator_gaintype", "actuator_biastype", "actuator_forcelimited", "actuator_forcerange"),
    *("actuator_ctrllimited", "actuator_ctrlrange", "actuator_gainprm", "site_bodyid", "site_pos", "geom_bodyid"),
    *("geom_pos", "eq_type", "eq_active0", "eq_obj1id", "eq_obj2id", "eq_data"),
)
NAMED = {"body": "nbody", "joint": "njnt", "site": "nsite", "geom": "ngeom", "equality": "neq"}


class RefusedError(Exception):
    """The file cannot be used, in words."""


def main(wanted: dict[str, Any]) -> None:
    """Compile and write what was found.

    Args:
        wanted: ``size`` of the file, ``parts``: (kind, name, size) of what follows it, kind "include" or "mesh";
            ``most`` bodies; ``seconds`` of processor time; ``bytes`` of memory.
    """
    _limit(resource.RLIMIT_CPU, wanted["seconds"])
    _limit(resource.RLIMIT_CORE, 0)
    os.environ["MUJOCO_GL"] = "disable"  # nothing is drawn here
    import mujoco

    text = sys.stdin.buffer.read(wanted["size"])
    parts: dict[str, dict[str, bytes]] = {"include": {}, "mesh": {}}
    for kind, name, size in wanted["parts"]:
        parts[kind][name] = sys.stdin.buffer.read(size)
    _limit(resource.RLIMIT_DATA, wanted["bytes"])
    _limit(resource.RLIMIT_NOFILE, 0)
    said: list[str] = []
    mujoco.set_mju_user_warning(lambda sentence: said.append(str(sentence)))  # else it prints
    try:
        found = _compiled(mujoco, text, parts, wanted["most"])
    except (RefusedError, ValueError, RuntimeError, MemoryError) as error:  # UnicodeError is a ValueError
        found = {"refused": str(error) or "it takes too much memory"}
    sys.stdout.write(json.dumps({**found, "said": [*dict.fromkeys(said), *found.get("said", [])]}))


def _limit(kind: int, most: int) -> None:
    """Lower a limit of this process; one that is lower already stays."""
    _, hard = resource.getrlimit(kind)
    resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _compiled(mujoco: Any, content: bytes, parts: dict[str, dict[str, bytes]], most: int) -> dict[str, Any]:
    """Drop what only looks, see which meshes are left, and compile."""
    spec = mujoco.MjSpec.from_string(content.decode(), include=parts["include"], assets=parts["mesh"])
    spec.compiler.fusestatic = False
    if len(spec.bodies) > most:
        raise RefusedError(f"it has {len(spec.bodies)} bodies; {most} are read at most")
    for body in spec.bodies:
        for geom in list(body.geoms):
            mesh = geom.type == mujoco.mjtGeom.mjGEOM_MESH
            if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD or (mesh and body.explicitinertial):
                spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for part in (*spec.skins, *(mesh for mesh in spec.meshes if mesh.name not in used), *spec.textures, *spec.hfields):
        spec.delete(part)
    needs = sorted({mesh.file for mesh in spec.meshes if mesh.file} - set(parts["mesh"]))
    if needs:
        return {"needs": needs, "folders": [spec.meshdir]}
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        model = spec.compile()
    names = {
        kind: [str(getattr(model, kind)(number).name) for number in range(getattr(model, count))]
        for kind, count in NAMED.items()
    }
    arrays = {name: getattr(model, name).tolist() for name in ARRAYS}
    own = model.names.split(b"\0")[0].decode()
    return {
        "name": own,
        "names": names,
        "tendons": model.ntendon,
        "arrays": arrays,
        "said": [str(w.message) for w in warned],
    }


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
