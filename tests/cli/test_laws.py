"""Law words: what is not a law of the pattern is one sentence, whatever stands in the word."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest

from amble.cli.options import parse_law, under
from amble.control.actuator import Actuator
from amble.control.allocation import BoundedMinimumNorm, DropActuator, MinimumPower, PseudoInverse, WeightedMinimumNorm
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.hybrid.gaits import amble
from amble.robot import catalogue

PATTERN = amble(catalogue.astro())

MOTOR = '"name":"own","torque_constant":0.1,"resistance":0.2,"gear_ratio":9,"source":"a test"'
OWN = Actuator("own", 0.1, 0.2, 9, "a test")
TWO = replace(OWN, joints={"fl_knee": OWN})

LAWS = {
    "pinv": PseudoInverse(),
    "drop:joints=rl_hip_pitch": DropActuator(("rl_hip_pitch",)),
    'drop:joints=["rl_hip_pitch","rr_hip_pitch"]': DropActuator(("rl_hip_pitch", "rr_hip_pitch")),
    "power:actuator=datasheet": MinimumPower("datasheet"),
    f'power:actuator={{{MOTOR},"joints":{{"fl_knee":{{{MOTOR}}}}}}}': MinimumPower(
        replace(OWN, joints={"fl_knee": OWN})
    ),
    "bounded:friction=1,normal_force=5.5": BoundedMinimumNorm(1, 5.5),
    'weighted:weights={"fl_knee": 2, "fr_knee": 0.5}': WeightedMinimumNorm({"fl_knee": 2, "fr_knee": 0.5}),
}


@pytest.mark.parametrize("word", LAWS)
def test_a_word_is_a_law(word: str) -> None:
    assert parse_law(word, PATTERN) == LAWS[word]


WRONG = {
    f'power:actuator={{{MOTOR},"joints":3}}': "joints of actuator 'own' are 3, not a motor for each",
    f'power:actuator={{{MOTOR},"joints":{{"fl_knee":null}}}}': "actuator of joint 'fl_knee' is no actuator model",
    "drop:joints=1.5": "joints to drop are 1.5; they must be a list of names",
    "drop:joints=null": "joints to drop are None",
    "drop:joints=true": "joints to drop are True",
    "drop:joints=[1]": "joints to drop are",
    'drop:joints={"a":1}': "joints to drop are",
    "drop:joints=[fl_knee]": "is not JSON",
    "drop:joint=fl_knee": "unknown parameter of allocation law 'drop' 'joint'; known: joints",
    "weighted": "allocation law 'weighted' needs the parameter 'weights'",
    'weighted:weights={"fl_knee":[1]}': "weight of joint 'fl_knee' is [1]; it must be a finite number",
    'weighted:weights={"fl_knee":"1"}': "weight of joint 'fl_knee' is 1; it must be a finite number",
    'weighted:weights={"fl_knee":null}': "weight of joint 'fl_knee' is None",
    'weighted:weights={"fl_knee":true}': "weight of joint 'fl_knee' is True",
    'weighted:weights={"fl_knee":1e999}': "weight of joint 'fl_knee' is inf",
    'weighted:weights={"a":1,"a":2}': "key 'a' twice",
    "weighted:weights=[1,2]": "not a number for every joint",
    "bounded:friction=" + "9" * 400: "more than 40 digits",
    "bounded:friction=" + "9" * 5000: "more than 40 digits",
    "bounded:friction=" + "[" * 500 + "]" * 500: "nested deeper than 32",
    "bounded:friction=0.6.1": "is not JSON",
    "bounded:friction=six": "friction coefficient is six; it must be a finite number",
    "bounded:friction=": "friction coefficient is ; it must be a finite number",
    "bounded:friction=1e308": "friction coefficient is 1e+308; parameters of laws go up to 1e+12",
    "bounded:normal_force=1e308": "smallest normal force is 1e+308; parameters of laws go up to 1e+12",
    'weighted:weights={"fl_knee":1e308}': "weight of joint 'fl_knee' is 1e+308; parameters of laws go up to 1e+12",
    "bounded:friction=-1": "must be finite and positive",
    "power:actuator=3": "unknown actuator '3'",
    "power:actuator=[]": "unknown actuator",
    "power:actuator=a\nb": r"unknown actuator 'a\nb'",
    "pinv:power=1": "unknown parameter of allocation law 'pinv' 'power'; known: none",
    "pinv:power": "'power' is not key=value",
    "": "unknown allocation law ''",
    "\ud800": "unknown allocation law",
}


@pytest.mark.parametrize("word", WRONG, ids=range(len(WRONG)))
def test_a_word_that_is_no_law_is_one_sentence(word: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_law(word, PATTERN)
    assert WRONG[word] in str(caught.value)
    assert str(caught.value).isprintable()


PARTS = (
    *("drop", "weighted", "bounded", "power", "peak", "pinv", ":", ":", "=", "=", ",", "joints", "weights", "friction"),
    *("normal_force", "actuator", "fl_knee", '"fl_knee"', "{", "}", "[", "]", "1", "-2.5", "1e400", "9" * 60, "null"),
    *("true", "NaN", '"', "\n", " ", "\x00", "\ud800", "é", "[" * 400),
)


@pytest.mark.parametrize("seed", range(5))
def test_drawn_words_are_laws_or_sentences(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(400):
        word = draw.choice(PARTS[:6]) + ":" * (draw.random() < 0.9) + "".join(draw.choices(PARTS, k=draw.randrange(9)))
        text = sentence(word)
        assert text.isprintable(), (word, text)
        assert len(text) < 1000


def sentence(word: str) -> str:
    """Return why a word is no law, nothing where it is one."""
    try:
        parse_law(word, PATTERN)
    except InputError as error:
        return str(error)
    return ""


def test_the_name_of_the_gaits_own_law_leaves_its_gains(stabilised_gait: Gait) -> None:
    """Its gains were those of a stabilisation, and robustness of the default ones refused the gait as unstable."""
    own = replace(stabilised_gait, control=Impedance(stance_stiffness=80.0))
    assert under(own, "impedance").control == own.control
    assert under(own, None) is own
    assert under(own, "impedance:swing_damping=2").control == Impedance(swing_damping=2.0)
    assert under(stabilised_gait, "impedance").control == Impedance()
