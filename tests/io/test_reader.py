"""Whatever is wrong with a file, it is one sentence, and nothing waits or grows."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from amble.errors import InputError
from amble.io import reader
from amble.io.reader import parse_json, parse_number, read_bytes, read_json, read_record, read_text, read_toml


def refused(path: str | Path, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        read_json(path, "a file")
    assert "\n" not in str(caught.value)
    assert str(caught.value).isprintable()


def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    refused(tmp_path / "pipe", "it is a device or a pipe, not a file")


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/null", "/dev/tty"])
def test_a_device_is_refused(device: str) -> None:
    refused(device, "a device or a pipe|No such device")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    refused(tmp_path, "it is a folder, not a file")


@pytest.mark.parametrize("name", ["a\0b", "a\ud800b"])
def test_a_name_that_no_file_has_is_refused(name: str) -> None:
    refused(name, "no file has such a name")


def test_a_name_with_a_line_break_stays_in_the_sentence(tmp_path: Path) -> None:
    refused(tmp_path / "a\nb", r"a\\nb.*No such file")


def test_a_very_long_name_does_not_fill_the_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the end' cannot be read: File name too long") as refused:
        read_bytes(tmp_path / ("x" * 100_000 + "the end"), "robot file")
    assert len(str(refused.value)) < 1000


def test_a_large_file_is_refused_without_reading_it(tmp_path: Path) -> None:
    path = tmp_path / "large"
    with path.open("wb") as stream:
        stream.truncate(2**36)  # sparse: takes no room on the disk
    refused(path, "it has more than 16 MB")


def test_a_file_is_held_to_its_limit_while_it_is_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"12345")
    assert read_bytes(tmp_path / "a", "a file", largest=5) == b"12345"
    with pytest.raises(InputError, match="has more than"):
        read_bytes(tmp_path / "a", "a file", largest=4)
    with pytest.raises(InputError, match="has more than"):  # its size is said to be 0
        read_bytes("/proc/self/status", "a file", largest=10)


def test_a_byte_order_mark_is_no_content(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xef\xbb\xbf{}")
    assert read_text(tmp_path / "a", "a file") == "{}"
    assert read_json(tmp_path / "a", "a file") == {}
    (tmp_path / "b").write_bytes(b"\xef\xbb\xbfa = 1")
    assert read_toml(tmp_path / "b", "a file") == {"a": 1}


WRONG = {
    "not text": (b'{"a": "\xff"}', "is not text in UTF-8"),
    "utf-16": ('{"a": 1}'.encode("utf-16"), "is not text in UTF-8"),
    "empty": (b"", "is not JSON"),
    "two": (b"{} {}", "is not JSON"),
    "no object": (b"[1]", "is not an object"),
    "nan": (b'{"a": NaN}', "holds NaN"),
    "twice": (b'{"a": {"b": 1, "b": 2}}', "key 'b' twice"),
    "twice, with a line break": (b'{"a\\n": 1, "a\\n": 2}', r"key 'a\\n' twice"),
    "digits": (b'{"a": ' + b"9" * 5000 + b"}", "more than 40 digits"),
    "1e400 as an integer": (b'{"a": 1' + b"0" * 400 + b"}", "more than 40 digits"),
    "brackets": (b'{"a": ' + b"[" * 300 + b"]" * 300 + b"}", "nested deeper than 32"),
    "braces": (b'{"a":' * 5000 + b"1" + b"}" * 5000, "nested deeper than 32"),
    "open brackets": (b"[" * 10**6, "nested deeper than 32"),
    "lone surrogate": (b'{"a": "\\ud800"}', "half of a surrogate pair"),
    "lone surrogate in a key": (b'{"a": {"\\udc00b": 1}}', "half of a surrogate pair"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_with_json_is_one_sentence(name: str, tmp_path: Path) -> None:
    content, match = WRONG[name]
    (tmp_path / "a.json").write_bytes(content)
    refused(tmp_path / "a.json", match)


def test_a_pair_of_surrogates_is_a_character() -> None:
    assert parse_json('"\\ud83d\\ude00"', "text") == "\U0001f600"


def test_the_bounds_are_where_they_are_said_to_be() -> None:
    deep, long = reader.DEEPEST, reader.LONGEST_INTEGER
    assert parse_json("[" * deep + "]" * deep, "text") is not None
    with pytest.raises(InputError, match="nested deeper"):
        parse_json("[" * (deep + 1) + "]" * (deep + 1), "text")
    assert parse_json("9" * long, "text") == 10**long - 1
    with pytest.raises(InputError, match="digits"):
        parse_json("1" * (long + 1), "text")


@pytest.mark.parametrize("word", ["1" * 40_000 + "x", "1." + "1" * 40_000 + "x", "1e" + "1" * 40_000 + "x"])
def test_a_long_word_is_no_number_in_linear_time(word: str) -> None:
    """Where a shorter start was tried after every digit, 40,000 digits took 3 s and a million half an hour."""
    begun = time.process_time()
    with pytest.raises(ValueError, match="is not a number"):
        parse_number(word)
    assert time.process_time() - begun < 0.5


def test_text_of_json_is_held_to_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "LARGEST_TEXT", 10)
    assert parse_json("[1, 2, 3 ]", "header") == [1, 2, 3]
    with pytest.raises(InputError, match="header cannot be read: it has more than"):
        parse_json("[1, 2, 3  ]", "header")


@pytest.mark.parametrize("part", ["a", '"a b"', "'.'", '"\\".\\""', "a "])
def test_a_deep_key_of_toml_is_refused_before_it_is_parsed(part: str, tmp_path: Path) -> None:
    """Python's parser keeps every start of a key: one of 20,000 parts, 40 kB, took 1.6 GB."""
    file, deep, begun = tmp_path / "a.toml", ".".join([part] * 20_000), time.process_time()
    for text in (f"{deep} = 1", f"[{deep}]\nb = 1", f"a = {{ b = 1, {deep} = 1 }}"):
        file.write_text(text)
        with pytest.raises(InputError, match="nested deeper than 32"):
            read_toml(file, "specification")
    assert time.process_time() - begun < 1.0
    file.write_text(f"{'.'.join([part.strip(), *'bcdefghijklmnopqrstuvwxyz12345'])} = 1")
    assert len(read_toml(file, "specification")) == 1


def test_toml_is_held_to_its_size(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("#\n" * (reader.LARGEST_TOML // 2 + 1))
    with pytest.raises(InputError, match="more than 1 MB"):
        read_toml(tmp_path / "a.toml", "specification")


WRONG_TOML = {
    "not toml": (b"a =", "is not TOML"),
    "digits": (b"a = " + b"9" * 5000, "more than 40 digits"),
    "hexadecimal": (b"a = 0x" + b"f" * 400, "more than 40 digits"),
    "brackets": (b"a = " + b"[" * 400 + b"]" * 400, "nested deeper than 32"),
    "dotted": (b"a" + b".a" * 400 + b" = 1", "nested deeper than 32"),
    "not text": (b"a = '\xff'", "is not text in UTF-8"),
}


@pytest.mark.parametrize("name", WRONG_TOML)
def test_what_is_wrong_with_toml_is_one_sentence(name: str, tmp_path: Path) -> None:
    content, match = WRONG_TOML[name]
    (tmp_path / "a.toml").write_bytes(content)
    with pytest.raises(InputError, match=match) as caught:
        read_toml(tmp_path / "a.toml", "a file")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["1", "-1.5e3", "+.5", "1.", "inf", "-Infinity", "nan"])
def test_decimal_numbers_are_read_as_python_does(text: str) -> None:
    assert repr(parse_number(text)) == repr(float(text))


@pytest.mark.parametrize("text", ["1_0", "٣", "0x1", "1 2", "", " 1", "1e", "--1", "1.5.2"])
def test_other_notations_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="not a number"):
        parse_number(text)


RECORDS = {
    "a key twice": ('{"a": 1, "a": 2}', "the key 'a' twice"),
    "no number": ('{"a": NaN}', "holds NaN"),
    "too many digits": (f'{{"a": {"9" * 400}}}', "more than 40 digits"),
    "too deep": ('{"a": ' + "[" * 100 + "]" * 100 + "}", "nested deeper"),
    "half a character": ('{"\\ud800": 1}', "half of a surrogate pair"),
    "another type": ('{"a": "1"}', r"cannot be used: a\.float: "),
    "a long key of another type": (f'{{"{"a" * 10_000}\\n": "1"}}', r"cannot be used: a+\.\.\.: "),
    "megabytes of lists": ("[" + "[]," * 1_000_000 + "[]]", "more than 1 MB"),
}


@pytest.mark.parametrize("what", RECORDS)
def test_what_is_wrong_with_a_record_is_one_sentence(what: str, tmp_path: Path) -> None:
    """pydantic alone took 2 GB for 16 MB of empty lists, and the process with it where there was less."""
    path = tmp_path / "a.json"
    path.write_text(RECORDS[what][0])
    with pytest.raises(InputError, match=RECORDS[what][1]) as caught:
        read_record(path, "record", TypeAdapter(dict[str, float | list[object]]))
    assert len(str(caught.value)) < 500
    assert str(caught.value).isprintable()


def test_a_record_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('\ufeff{"a": 1.5}', encoding="utf-8")
    assert read_record(tmp_path / "a.json", "record", TypeAdapter(dict[str, float])) == {"a": 1.5}
