"""What a clip gets: checked where it is written, the same after a trip through JSON."""

from __future__ import annotations

import json

import pytest

from retime.batch.recipe import Recipe, Rule, read_recipe
from retime.batch.treatment import Treatment, settings
from retime.errors import FormatError, OptionError, RetimeWarning


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"length": "80%", "lock": ["1..2", "3..4=1/2"], "max-skip": 3, "evenness": 0.5},
        {"length": 9.5, "key": "2.5=1.8", "reference": ["a.bvh", "b.bvh"], "mirror": True, "average": False},
        {"variants": 8, "speeds": "0.8..1.25", "seed": 7, "beside": "{stem}_labels.csv", "format": ".bvh"},
        {"method": "linear", "length": "280f", "frames": "1:80", "fps": 29.97, "gaps": "bridge:0.2", "on": 2},
        {"influence": "0=1,2.5=50%", "speed": "1/4..8", "paper": True, "search": "heuristic", "channel": "*.q=linear"},
    ],
)
def test_a_treatment_comes_back_from_json(given: dict[str, object]) -> None:
    made = Treatment().with_(settings(given))
    back = Treatment().with_(settings(json.loads(json.dumps(made.to_json()))))
    assert back == made
    assert back.to_json() == made.to_json()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"lenght": "80%"}, "lenght: there is no such setting; did you mean length"),
        ({"length": "80 %%"}, "length: "),
        ({"lock": "1..2..3"}, "lock: "),
        ({"lock": 5}, "expected one text or several"),
        ({"mirror": "yes"}, "expected true or false"),
        ({"variants": -1}, "whole number of at least 0"),
        ({"variants": True}, "whole number"),
        ({"on": 0}, "whole number of at least 1"),
        ({"format": "bvh"}, "ending such as .bvh"),
        ({"format": "./x"}, "ending such as .bvh"),
        ({"beside": "../{stem}.csv"}, "with {stem} in it"),
        ({"beside": "labels.csv"}, "with {stem} in it"),
        ({"max_skip": 1e9}, "max_skip"),
        ({"evenness": [1]}, "expected a text or a number"),
        ({"paper": 1}, "must be True or False"),
        ({"speed": "8..1/4"}, "speed"),
        ({"up": "x"}, None),
    ],
)
def test_what_says_nothing_is_refused_by_its_name(given: dict[str, object], said: str | None) -> None:
    with pytest.raises(OptionError) as caught:
        Treatment().with_(settings(given))
    assert said is None or said in str(caught.value)


@pytest.mark.parametrize(
    "given",
    [
        {"variants": 3, "length": "80%"},
        {"variants": 3, "key": "1=2"},
        {"variants": 3, "method": "linear"},
        {"speeds": "0.8..1.25"},
        {"variants": 2, "speeds": "0.5..uncut"},
        {"draw_references": True, "reference": ["a.bvh", "b.bvh"]},
        {"variants": 2, "draw_references": 1},
    ],
)
def test_variants_draw_their_own_lengths(given: dict[str, object]) -> None:
    with pytest.raises(OptionError):
        Treatment().with_(settings(given))


def test_later_rules_win_and_rows_win_over_rules() -> None:
    recipe = Recipe(
        Treatment(search={"length": "90%"}),
        (
            Rule("dance/*", settings({"length": "120%", "evenness": 2})),
            Rule("*slow*", settings({"length": "150%"})),
            Rule("dance/calibration*", {}, skip=True),
        ),
        {"dance/calibration_slow.bvh": settings({"lock": "1..2"})},
    )
    found = {
        name: recipe.treatment_of(name)
        for name in (
            "walk.bvh",
            "dance/a/b.bvh",
            "dance/slow.bvh",
            "dance/calibration.bvh",
            "dance/calibration_slow.bvh",
        )
    }
    assert found["walk.bvh"] == Treatment(search={"length": "90%"})
    assert found["dance/a/b.bvh"] == Treatment(search={"length": "120%", "evenness": 2})
    assert found["dance/slow.bvh"] == Treatment(search={"length": "150%", "evenness": 2})
    assert found["dance/calibration.bvh"] is None
    # A row of its own brings a clip back.
    assert found["dance/calibration_slow.bvh"] == Treatment(search={"length": "150%", "evenness": 2}, lock=("1..2",))


def test_a_recipe_is_read_from_toml_and_its_table(tmp_path) -> None:
    (tmp_path / "recipe.toml").write_text(
        'length = "90%"\ntable = "clips.csv"\n\n[[rule]]\nmatch = "limps/*"\nreference = ["refs/limp.bvh"]\n'
        '\n[[rule]]\nmatch = "raw/*"\nskip = true\n'
    )
    (tmp_path / "clips.csv").write_text(
        "clip,length,lock,mirror,max_skip\nwalks/a.bvh,280f,1..2; 3..4,true,3\nwalks\\b.bvh,,,,\n"
    )
    recipe = read_recipe(tmp_path / "recipe.toml", Treatment(average=False))
    assert recipe.treatment_of("x.bvh") == Treatment(search={"length": "90%"}, average=False)
    limps = recipe.treatment_of("limps/x.bvh")
    assert limps is not None
    assert limps.reference == (str(tmp_path / "refs/limp.bvh"),)
    assert recipe.treatment_of("raw/x.bvh") is None
    assert recipe.treatment_of("walks/a.bvh") == Treatment(
        search={"length": "280f", "max_skip": 3}, lock=("1..2", "3..4"), mirror=True, average=False
    )
    assert set(recipe.rows) == {"walks/a.bvh", "walks/b.bvh"}
    with pytest.raises(OptionError, match=r"1 clips of the recipe's table are not there: walks/b\.bvh"):
        recipe.refuse_unknown(["walks/a.bvh", "limps/x.bvh", "raw/x.bvh"])
    with pytest.warns(RetimeWarning, match="no clip fits the recipe's pattern 'raw/"):
        recipe.refuse_unknown(["walks/a.bvh", "walks/b.bvh", "limps/x.bvh"])


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("r.toml", "length = ", "not a recipe"),
        ("r.toml", "length = " + "9" * 5000, "not a recipe"),
        ("r.toml", "rule = 5", r"\[\[rule\]\]"),
        ("r.toml", "[[rule]]\nlength = '80%'", "rule 1 needs match"),
        ("r.toml", "[[rule]]\nmatch = 'a'\nlength = 'x'", "rule 1: length"),
        ("r.toml", "table = 3", "table names a CSV"),
        ("r.csv", "name,length\na,80%\n", "column called clip"),
        ("r.csv", "clip,length\na,80%\na,90%\n", "a has two rows"),
        ("r.csv", "clip,length,length\na,80%,90%\n", "r.csv:1: two columns are called length"),
        ("r.csv", "length,clip\n80%\n", "r.csv:2: the row names no clip"),
        ("r.csv", "clip,length\n ,80%\n", "r.csv:2: the row names no clip"),
        ("r.csv", "clip,rate\na," + "9" * 5000 + "\n", "rate"),
        ("r.csv", "clip,length\na,80%,90%\n", "3 cells"),
        ("r.csv", "clip,length\na,eighty\n", ":2: length"),
        ("r.csv", "clip,skip\na,perhaps\n", ":2: skip is true or false"),
    ],
)
def test_a_broken_recipe_is_refused_with_its_place(tmp_path, name: str, text: str, said: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises((FormatError, OptionError), match=said) as caught:
        read_recipe(tmp_path / name, Treatment())
    assert name in str(caught.value)


def test_of_variants_the_speed_is_their_mean_wherever_it_is_written() -> None:
    base = Treatment().with_(settings({"speed": "0.8..1.25"}))
    assert base.search == {"speed": "0.8..1.25"}
    recipe = Recipe(base, (Rule("*_v.bvh", settings({"variants": 3})), Rule("s_v.bvh", settings({"speed": "0.5..2"}))))
    varied, own, plain = (recipe.treatment_of(name) for name in ("a_v.bvh", "s_v.bvh", "b.bvh"))
    assert varied == Treatment(variants=3, speeds="0.8..1.25")
    assert own == Treatment(variants=3, speeds="0.5..2")
    assert plain == base
    # A rule without variants draws no reference, and has no range of their lengths.
    drawing = Treatment().with_(settings({"variants": 3, "draw_references": True}))
    assert drawing.with_(settings({"variants": 0})) == Treatment()
    whole = Treatment().with_(settings({"variants": 3, "speed": "0.8..1.25"}))
    assert whole == Treatment(variants=3, speeds="0.8..1.25")
    assert whole.with_({"variants": 0}) == Treatment()
    with pytest.raises(OptionError, match="is for variants"):
        Treatment().with_(settings({"speeds": "0.8..1.25"}))


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_table_is_read_however_its_cells_are_parted(tmp_path, delimiter: str) -> None:
    rows = [["Clip", "Length", "lock", "skip"], ["a.bvh", "280f", '"1..2; 3..4"', ""], ["b.bvh", "", "", "TRUE"]]
    (tmp_path / "r.csv").write_text("".join(delimiter.join(row) + "\n" for row in rows), encoding="utf-8-sig")
    recipe = read_recipe(tmp_path / "r.csv", Treatment(average=False))
    assert recipe.treatment_of("a.bvh") == Treatment(search={"length": "280f"}, lock=("1..2", "3..4"), average=False)
    assert recipe.treatment_of("b.bvh") is None
    assert recipe.treatment_of("c.bvh") == Treatment(average=False)
