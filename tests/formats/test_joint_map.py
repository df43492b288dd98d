from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import FormatError
from retime.formats.joint_map import read_joint_map
from retime.formats.read_options import Limits


@pytest.fixture
def write(tmp_path):
    def write(content: str | bytes, suffix: str = ".json"):
        path = tmp_path / f"map{suffix}"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize(
    ("suffix", "content"),
    [
        (".json", '{"Hips": "root", "Left Foot": "lfoot,x"}'),
        (".json", '\ufeff{\r\n\t"Hips" :"root",\r"Left\\u0020Foot": "lfoot\\u002cx" }\n'),
        (".json", '{"Hips": "root", "Left Foot": "lfoot,x"}'.encode("utf-16")),
        (".csv", 'Hips,root\nLeft Foot,"lfoot,x"\n'),
        (".csv", '\ufeffInput,Reference\r\n\r\nHips, root\r\n,\r\nLeft Foot,"lfoot,x"'),
        (".CSV", "Hips;root\rLeft Foot;lfoot,x\r"),
        (".csv", "input\treference\nHips\troot\nLeft Foot\tlfoot,x"),
        (".csv", '"Hips";"root"\n"Left Foot";"lfoot,x"'),
    ],
)
def test_a_map_is_read(write, suffix, content) -> None:
    found = read_joint_map(write(content, suffix))
    assert list(found.items()) == [("Hips", "root"), ("Left Foot", "lfoot,x")]


def test_names_of_any_script_are_read(write) -> None:
    names = {"左足": "нога", "a:b|c": 'say "left"', "\U0001f9b6": "\\"}
    assert read_joint_map(write(json.dumps(names))) == names
    assert read_joint_map(write(json.dumps(names, ensure_ascii=False))) == names


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        ("", None, "empty; expected a joint map"),
        (" \n ", None, "empty; expected a joint map"),
        ("{}", None, "names no joint"),
        ("[1]", 1, "expected a JSON object.*found '\\[1\\]'"),
        ('\n{"a" "b"}', 2, "expected a colon after the input joint, found '\"b\"}'"),
        ('{"a": "b"\n', 2, "expected a comma, or } at the end of the object, found the end of it"),
        ('{"a": "b",}', 1, "expected the name of an input joint, in quotes"),
        ('{"a":\n 3}', 2, "expected the name of a reference joint, in quotes .*, found '3}'"),
        ('{"a":\n["b"]}', 2, "expected the name of a reference joint"),
        ('{"a": null}', 1, "expected the name of a reference joint"),
        ("{a: b}", 1, "expected the name of an input joint"),
        ("{'a': 'b'}", 1, "expected the name of an input joint"),
        ('{"a": "b"} x', 1, "expected nothing after the object, found 'x'"),
        ('{"a": "b\n"}', 1, "expected the name of a reference joint"),
        ('{"a": "b\\q"}', 1, "expected the name of a reference joint"),
        ('{"a": "b",\n"a": "c"}', 2, "the input joint 'a' stands here a second time, after line 1"),
        ('{"a": "b",\n\r\n\r"c": "b"}', 4, "the reference joint 'b' stands here a second time, after line 1"),
        ('{"": "b"}', 1, "expected the name of a joint of the input, found none"),
        ('{"a": " "}', 1, "expected the name of a joint of the reference, found none"),
        ('{"a": "\\ud800"}', 1, "half a character"),
        ("[" * 100_000, 1, "expected a JSON object"),
        ('{"a":' * 100_000, 1, "expected the name of a reference joint"),
    ],
)
def test_a_broken_json_map_is_refused_with_its_line(write, content, line, message) -> None:
    with pytest.raises(FormatError, match=message) as caught:
        read_joint_map(write(content))
    assert caught.value.line == line
    assert caught.value.path is not None


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        ("\n\n", None, "empty; expected a joint map"),
        ("input,reference\n", None, "names no joint"),
        ("a,b\nc\n", 2, "expected two fields, input joint and reference joint, found 1"),
        ("a,b,c\n", 1, "found 3"),
        ("a,b\n\na,c\n", 3, "the input joint 'a' stands here a second time, after line 1"),
        ("a,b\nc,b\n", 2, "the reference joint 'b' stands here a second time, after line 1"),
        ("a,\n", 1, "expected the name of a joint of the reference, found none"),
        ("a,b\ninput,reference\nreference,input\ninput,x\n", 4, "the input joint 'input' stands here a second time"),
        ('a,"b\nc', 2, "unexpected end of data"),
        ('a,"b"c', 1, "expected fields separated by ','"),
        ('{"a": "b"}', None, "this is a JSON document; expected a joint map"),
        (b"a,b\n\xff,c\n", 2, "expected UTF-8 text"),
        (b"\x89PNG\r\n\x1a\n", None, "this is a PNG picture"),
    ],
)
def test_a_broken_csv_map_is_refused_with_its_line(write, content, line, message) -> None:
    with pytest.raises(FormatError, match=message) as caught:
        read_joint_map(write(content, ".csv"))
    assert caught.value.line == line


def test_limits_are_kept(write) -> None:
    path = write('{"a": "b", "c": "d"}')
    for limits, message in (
        (Limits(joints=1), r"more than 1 joints \(Limits.joints\)"),
        (Limits(file_bytes=5), r"Limits.file_bytes"),
    ):
        with pytest.raises(FormatError, match=message):
            read_joint_map(path, limits=limits)
    with pytest.raises(FormatError, match=r"a name has 1025 bytes, the limit is 1024 \(Limits.name_bytes\)"):
        read_joint_map(write(json.dumps({"a": "b" * 1025})))


def test_a_file_that_is_no_map_is_refused_by_its_name(write) -> None:
    with pytest.raises(FormatError, match=r"ends in .json or .csv, found '.txt'"):
        read_joint_map(write("a,b", ".txt"))


names = st.text(st.characters(codec="utf-8"), min_size=1, max_size=5).filter(str.strip)


@settings(max_examples=50)
@given(joints=st.dictionaries(names, names, min_size=1, max_size=5).filter(lambda m: len(set(m.values())) == len(m)))
def test_what_json_writes_is_read_back(tmp_path_factory, joints) -> None:
    path = tmp_path_factory.mktemp("maps") / "map.json"
    path.write_text(json.dumps(joints), encoding="utf-8")
    assert read_joint_map(path) == joints


@settings(max_examples=200)
@given(
    data=st.one_of(st.binary(max_size=60), st.text('{}":,\\ab\n', max_size=20).map(str.encode)),
    suffix=st.sampled_from(["json", "csv"]),
)
def test_any_bytes_are_a_map_or_a_format_error(tmp_path_factory, data, suffix) -> None:
    path = tmp_path_factory.mktemp("maps") / f"map.{suffix}"
    path.write_bytes(data)
    try:
        found = read_joint_map(path)
    except FormatError as error:
        found, place = None, error.path
    if found is None:
        assert place == str(path)
    else:
        assert found
        assert all(name.strip() for pair in found.items() for name in pair)
