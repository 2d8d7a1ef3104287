"""All kinds of input by name."""

from __future__ import annotations

from fuzz import kinds, meshes, mjcf, motions, records, traces
from fuzz.kinds import Kind

READERS = (
    Kind("gait", ".json", 30, kinds.draw_gait, kinds.read_gait),
    Kind("urdf", ".urdf", 25, kinds.draw_urdf, kinds.read_urdf),
    Kind("mjcf", ".xml", 3, mjcf.draw_mjcf, mjcf.read_mjcf),  # as traces are
    Kind("specification", ".toml", 20, kinds.draw_specification, kinds.read_specification),
    Kind("results", ".json", 10, kinds.draw_results, kinds.read_results),
    Kind("law", ".txt", 12, kinds.draw_law, kinds.read_law),
    Kind("stl", ".stl", 2, meshes.draw_stl, meshes.read_mesh),
    Kind("obj", ".obj", 2, meshes.drawing(meshes.OBJ), meshes.read_mesh),
    Kind("dae", ".dae", 5, meshes.drawing(meshes.DAE), meshes.read_mesh),
    Kind("trace", ".nc", 3, traces.draw_trace, traces.read_trace),  # each is read in a process of its own: 0.3 s
    Kind("npz", ".npz", 4, motions.drawer(".npz"), motions.read_motion),
    Kind("csv", ".csv", 4, motions.drawer(".csv"), motions.read_motion),
    Kind("mat", ".mat", 1, motions.drawer(".mat"), motions.read_motion),  # as traces are
    Kind("library", ".toml", 4, records.draw_library, records.read_library),
    Kind("record", ".json", 4, records.drawer(records.RECORD), records.read_record),
    Kind("transitions", ".json", 2, records.drawer(records.HEADER), records.read_transitions),  # 1 s where it loads
    Kind("commands", ".csv", 4, records.draw_commands, records.read_commands),
    Kind("log", ".csv", 4, records.draw_log, records.read_log),
    Kind("proof", ".json", 4, records.draw_proof, records.read_proof),
    Kind("srdf", ".srdf", 4, records.draw_srdf, records.read_srdf),
)

BY_NAME = {kind.name: kind for kind in READERS}
