"""Figure 16 under the chapter's own conditions, on one run."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.experiments import EXPERIMENTS, drawn_rooms, figure_16_conditions
from core.experiments.figure_16_conditions import (
    CHAPTER,
    CHAPTER_CONDITIONS,
    FAIR_CONDITIONS,
    PAPER_ERROR_M,
    errors,
    limit,
    mean_length,
)
from core.experiments.paper_course import Draws, reckoned


def test_the_first_condition_is_the_chapter_s_and_the_four_are_its_field_and_names() -> None:
    assert (CHAPTER.field, CHAPTER.ids, CHAPTER.still, CHAPTER.spacing) == ("camera", "hidden", False, None)
    assert CHAPTER_CONDITIONS[0] is CHAPTER
    assert {(one.field, one.ids) for one in CHAPTER_CONDITIONS} == {
        (field, ids) for field in ("camera", "laser") for ids in ("given", "hidden")
    }


@pytest.mark.parametrize("sds", [(0.1, 0.1), (0.3, 0.02), (0.2, 0.0)])
def test_the_mean_length_of_a_gaussian_vector_is_that_of_many_drawn_ones(sds: tuple[float, float]) -> None:
    drawn = np.random.default_rng(1).standard_normal((200_000, 2)) * sds
    assert mean_length(np.diag(np.square(sds))) == pytest.approx(np.hypot(*drawn.T).mean(), rel=0.01)


def test_the_limit_follows_what_is_seen_and_how_well_the_wheels_know() -> None:
    """Cause by cause: a wider field, a farther laser and quieter wheels each allow a smaller error."""
    as_printed, fair, far = (
        limit(one.draws(0), still=False) for one in (CHAPTER, FAIR_CONDITIONS[0], FAIR_CONDITIONS[3])
    )
    assert as_printed > fair > far > limit(CHAPTER_CONDITIONS[2].draws(0), still=False) > 0


def test_in_the_fair_rows_dead_reckoning_errs_as_in_print() -> None:
    assert max(reckoned(FAIR_CONDITIONS[0].draws(0).run(number)).average for number in range(40)) == pytest.approx(
        0.2, abs=0.005
    )


def test_a_drawn_room_has_twelve_corners_about_the_drive_and_is_another_for_every_number() -> None:
    rooms = [FAIR_CONDITIONS[0].draws(0, room=number).course for number in range(5)]
    for one in rooms:
        assert one.landmarks.shape == (12, 2)
        assert np.all(one.landmarks.min(axis=0) < one.truth[:, :2].min(axis=0) - 0.9)
        assert np.all(one.landmarks.max(axis=0) > one.truth[:, :2].max(axis=0) + 0.9)
    assert len({one.landmarks.tobytes() for one in rooms}) == 5


def test_who_knows_the_map_errs_less_than_who_has_to_make_it() -> None:
    one = errors(Draws(field="camera", ids="hidden"), False, 3)
    assert 0 < one.known < one.slam and one.known < 0.06
    assert np.isfinite(one.nees) and one.dead > 0


def test_the_table_says_the_condition_under_every_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(figure_16_conditions, "CHAPTER_CONDITIONS", (CHAPTER,))
    monkeypatch.setattr(figure_16_conditions, "FURTHER", ())
    monkeypatch.setattr(figure_16_conditions, "FAIR_CONDITIONS", ())
    result: Any = EXPERIMENTS["figure-16-conditions"](runs=1, out=tmp_path, workers=1)
    assert CHAPTER.subtitle in result["text"] and "edges required; names hidden" in CHAPTER.subtitle
    saved = json.loads(Path(result["files"]["json"]).read_text())
    assert saved["conditions"] == result["conditions"]


def test_the_share_of_drawn_rooms_is_that_of_the_rooms_whose_worst_drive_errs_as_little_as_in_print(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(drawn_rooms, "DRIVES_PER_ROOM", 1)
    drawn = drawn_rooms.plan(runs=2)
    far = [drawn.batches[1].work(number) for number in range(2)]
    row = drawn.finish([*far, *far], None)["conditions"][1]
    assert row["share_within_paper"] == sum(one.worst <= PAPER_ERROR_M for one in far) / 2
    assert row["worst_m"][1] == pytest.approx(sum(one.worst for one in far) / 2)
    assert all(0 < one.limit < 0.2 and one.worst == one.mean for one in far)
    assert "laser to 5.6 m" in row["condition"]
