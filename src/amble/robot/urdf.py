"""Reading a URDF file: links and joints as written, without meshes and without interpretation.

The standard library's XML parser is enough, imports in milliseconds, keeps file order and leaves every sentence about
what is wrong to us.
"""

from __future__ import annotations

import codecs
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from amble.amounts import LARGEST_NUMBER
from amble.errors import InputError, shown, shown_path
from amble.io.reader import parse_number, read_bytes
from amble.io.xml import parse_xml
from amble.names import check_name
from amble.robot.rotation import rotation_of_rpy
from amble.types import Matrix, Vector, frozen

LARGEST = 8 * 2**20
"""Bytes of a robot file; those of real robots have up to 0.3 MB."""

HEAD = 4096
"""Bytes in which the XML declaration is looked for."""

DECLARATION = re.compile(r"(?>\s|<!--.*?-->)*+(?P<declaration><\?xml\s.*?\?>)", re.DOTALL)
ENCODING = re.compile(r"""encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
NOT_OF_FILES = ("idna", "punycode", "raw_unicode_escape", "undefined", "unicode_escape", "utf-7")
"""Encodings of Python that no editor writes; two of them take quadratic time."""


@dataclass(frozen=True)
class FileLink:
    """A link as written: mass, centre and inertia in link axes; all zero without an inertial element."""

    name: str
    mass: float
    center: Vector
    inertia: Matrix


@dataclass(frozen=True, kw_only=True)
class FileJoint:
    """A joint as written; limits that the file does not give are infinite.

    A joint that mimics another follows it: angle = factor * its angle + offset, with ``mimic`` (factor, offset).
    """

    name: str
    kind: str
    parent: str
    child: str
    rotation: Matrix
    translation: Vector
    axis: Vector = field(default_factory=lambda: frozen([1.0, 0.0, 0.0]))
    lower: float = -np.inf
    upper: float = np.inf
    effort: float = np.inf
    velocity: float = np.inf
    mimics: str | None = None
    mimic: tuple[float, float] = (1.0, 0.0)
    rotor_inertia: float = 0.0
    damping: float = 0.0
    dry_friction: float = 0.0


@dataclass(frozen=True)
class FileRobot:
    """Name, links and joints in file order, and a sentence for everything of weight that is not read.

    A planar robot is one whose virtual joints let its base move in the plane of x and z.
    """

    name: str
    links: tuple[FileLink, ...]
    joints: tuple[FileJoint, ...]
    unused: tuple[str, ...] = ()
    planar: bool = False


def read_urdf(path: Path) -> FileRobot:
    """Read a URDF file.

    Raises:
        InputError: where the file is missing, is not a URDF, or an element is incomplete or not a number.
    """
    root = parsed_urdf(path)
    links = tuple(_link(element, path) for element in root.findall("link"))
    rotors = _rotors(root, path)
    joints = tuple(_joint(element, path, rotors) for element in root.findall("joint"))
    return FileRobot(root.get("name") or path.stem, links, joints, _unused(root, path))


def parsed_urdf(
    path: Path, what: str = "robot file", kind: str = "URDF", largest: int = LARGEST
) -> ElementTree.Element:
    """Return the root element of a URDF file, or of another whose root is a robot; errors as in ``read_urdf``."""
    name = f"{what} '{shown_path(path)}'"
    text = _decoded(read_bytes(path, what, largest), name)
    try:
        root = parse_xml(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"{name} is not well-formed XML: {shown(str(error))}") from error
    space = re.match(r"\{[^}]*\}", root.tag)
    for element in root.iter():
        tag = str(element.tag)
        if "xacro" in tag:
            raise InputError(f"{name} holds xacro macros; expand them first")
        if space and tag.startswith(space.group()):
            element.tag = tag[space.end() :]  # a default namespace changes nothing of what a URDF means
    if root.tag != "robot":
        raise InputError(f"{name} is not a {kind}: its root element is '{shown(root.tag)}', not 'robot'")
    return root


def _decoded(content: bytes, name: str) -> str:
    """Return the text of an XML file in the encoding that it declares, UTF-8 where it declares none.

    The declaration is blanked out, so that lines keep their numbers: files in use have blank lines or a comment before
    it, and encodings that the parser does not know.
    """
    encoding = "utf-16" if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) else "utf-8-sig"
    if encoding != "utf-16":
        # every other encoding in use writes the declaration in ASCII
        found = DECLARATION.match(content.removeprefix(codecs.BOM_UTF8)[:HEAD].decode("latin-1"))
        declared = None if found is None else ENCODING.search(found.group("declaration"))
        encoding = encoding if declared is None else declared.group(1)
    try:
        known = codecs.lookup(encoding).name
        if known in NOT_OF_FILES:
            raise InputError(f"{name} is in '{known}', which is not an encoding of files")
        text = content.decode("utf-8-sig" if known == "utf-8" else encoding)
    except (LookupError, UnicodeError) as error:
        raise InputError(f"{name} is not text in the encoding '{shown(encoding)}': {shown(str(error))}") from None
    found = DECLARATION.match(text[:HEAD])
    end = 0 if found is None else found.end()
    return re.sub(r"[^\n]", " ", text[:end]) + text[end:]


READ = ("link", "joint", "material", "transmission")
"""Elements of a robot that are read, or that are looks."""


def _unused(root: ElementTree.Element, path: Path) -> tuple[str, ...]:
    """Say what the file states about the motion that amble does not use."""
    notes: list[str] = []
    for joint in root.findall("joint"):
        notes += [
            f"joint '{joint.get('name')}' has a '{tag}', which is not used"
            for tag in ("safety_controller", "calibration")
            if joint.find(tag) is not None
        ]
    plain = [element for element in root.findall("transmission") if not _reflected(element, path)]
    if plain:
        notes.append(f"elements 'transmission' without motorInertia ({len(plain)}) are not used")
    others = [str(element.tag) for element in root if element.tag not in READ and isinstance(element.tag, str)]
    notes += [f"elements '{shown(tag)}' ({others.count(tag)}) are not used" for tag in dict.fromkeys(others)]
    return tuple(notes)


def _rotors(root: ElementTree.Element, path: Path) -> dict[str, float]:
    """Return joint -> rotor inertia as the joint feels it, kg m^2, of the transmissions that state it."""
    found: dict[str, float] = {}
    for transmission in root.findall("transmission"):
        for name, inertia in _reflected(transmission, path).items():
            found[name] = found.get(name, 0.0) + inertia
    return found


def _reflected(transmission: ElementTree.Element, path: Path) -> dict[str, float]:
    """Joint -> N^2 I of a transmission with one motor: mechanicalReduction N, motorInertia I."""
    joints = [joint.get("name") for joint in transmission.findall("joint")]
    inertias, ratios = (
        [
            number(found.text or "", f"{path.name}: transmission '{transmission.get('name')}', {tag}")
            for found in transmission.iter(tag)
        ]
        for tag in ("motorInertia", "mechanicalReduction")
    )
    if len(joints) != 1 or joints[0] is None or len(inertias) != 1 or not inertias[0]:
        return {}
    return {joints[0]: (ratios[0] if ratios else 1.0) ** 2 * inertias[0]}


def _link(element: ElementTree.Element, path: Path) -> FileLink:
    name = attribute(element, "name", f"{path.name}: a link")
    check_name(f"link of {path.name}", name)
    where = f"{path.name}: link '{name}'"
    inertial = element.find("inertial")
    if inertial is None:
        return FileLink(name, 0.0, frozen(np.zeros(3)), frozen(np.zeros((3, 3))))
    rotation, center = origin_of(inertial, where)
    mass = inertial.find("mass")
    if mass is None:
        raise InputError(f"{where} has an inertial element without mass")
    tensor = np.zeros((3, 3))
    inertia = inertial.find("inertia")
    if inertia is not None:
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
            row, column = ("xyz".index(letter) for letter in key[1:])
            tensor[row, column] = tensor[column, row] = number(attribute(inertia, key, where), f"{where}, {key}")
    value = number(attribute(mass, "value", where), f"{where}, mass")
    return FileLink(name, value, center, frozen(rotation @ tensor @ rotation.T))


def _joint(element: ElementTree.Element, path: Path, rotors: Mapping[str, float]) -> FileJoint:
    name = attribute(element, "name", f"{path.name}: a joint")
    check_name(f"joint of {path.name}", name)
    where = f"{path.name}: joint '{name}'"
    kind = attribute(element, "type", where)
    rotation, translation = origin_of(element, where)
    limit, mimic = element.find("limit"), element.find("mimic")
    given = {} if limit is None else limit.attrib
    drive = {} if (dynamics := element.find("dynamics")) is None else dynamics.attrib
    follows = {} if mimic is None else mimic.attrib
    bounds = [
        number(given[key], f"{where}, limit {key}", infinite=True) if key in given else default
        for key, default in (("lower", -math.inf), ("upper", math.inf), ("effort", math.inf), ("velocity", math.inf))
    ]
    lower, upper, effort, velocity = bounds
    if lower > upper:
        raise InputError(f"{where} has its lower limit {lower:g} above its upper limit {upper:g}")
    return FileJoint(
        name=name,
        kind=kind,
        parent=_reference(element, "parent", where),
        child=_reference(element, "child", where),
        rotation=rotation,
        translation=translation,
        axis=_axis(element, kind, where),
        lower=lower,
        upper=upper,
        effort=effort,
        velocity=velocity,
        mimics=None if mimic is None else attribute(mimic, "joint", where),
        mimic=(
            number(follows.get("multiplier", "1"), f"{where}, mimic multiplier"),
            number(follows.get("offset", "0"), f"{where}, mimic offset"),
        ),
        rotor_inertia=rotors.get(name, 0.0),
        damping=number(drive.get("damping", "0"), f"{where}, damping"),
        dry_friction=number(drive.get("friction", "0"), f"{where}, friction"),
    )


def _axis(element: ElementTree.Element, kind: str, where: str) -> Vector:
    axis = element.find("axis")
    if axis is None or kind in ("fixed", "floating"):
        return frozen([1.0, 0.0, 0.0])
    direction = triple(attribute(axis, "xyz", where), f"{where}, axis")
    largest = float(np.max(np.abs(direction)))
    if largest == 0.0:
        raise InputError(f"{where} has an axis of length zero")
    direction = np.ldexp(direction, -math.frexp(largest)[1])  # exact; squares of very small numbers are zero
    return frozen(direction / np.linalg.norm(direction))


def _reference(element: ElementTree.Element, tag: str, where: str) -> str:
    found = element.find(tag)
    if found is None:
        raise InputError(f"{where} has no {tag} link")
    return attribute(found, "link", where)


def origin_of(element: ElementTree.Element, where: str) -> tuple[Matrix, Vector]:
    """Return rotation and translation (m) of an element's origin; ``where`` begins the sentence of an error."""
    origin = element.find("origin")
    xyz = "0 0 0" if origin is None else origin.get("xyz", "0 0 0")
    rpy = "0 0 0" if origin is None else origin.get("rpy", "0 0 0")
    angles = triple(rpy, f"{where}, origin rpy")
    return frozen(rotation_of_rpy(angles)), frozen(triple(xyz, f"{where}, origin xyz"))


def attribute(element: ElementTree.Element, key: str, where: str) -> str:
    """Return an attribute that has to be there."""
    value = element.get(key)
    if value is None:
        raise InputError(f"{where} has a '{element.tag}' element without '{key}'")
    return value


def triple(text: str, where: str) -> Vector:
    """Return three numbers."""
    parts = text.split()
    if len(parts) != 3:
        raise InputError(f"{where} is '{shown(text)}', not three numbers")
    return np.array([number(part, where) for part in parts])


def number(text: str, where: str, infinite: bool = False) -> float:
    """Return a number, finite unless ``infinite``."""
    try:
        value = parse_number(text.strip())
    except ValueError:
        raise InputError(f"{where} is '{shown(text)}', not a number") from None
    if math.isnan(value) or (math.isinf(value) and not infinite):
        raise InputError(f"{where} is '{shown(text)}', not a finite number")
    if not infinite and abs(value) > LARGEST_NUMBER:
        raise InputError(f"{where} is '{shown(text)}'; numbers of a robot go up to {LARGEST_NUMBER:g}")
    return value
