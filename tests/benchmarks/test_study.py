"""Intervals of the study over trainings with other seeds."""

import numpy as np
import pytest
from scipy.stats import ttest_1samp

from benchmarks.estimators.marked import replace_table
from benchmarks.estimators.over_seeds import as_markdown, seed_interval, seed_p, sentences, standing
from benchmarks.estimators.study import METRICS


def test_the_interval_over_seeds_is_that_of_the_t_test():
    for values in ([0.1, 0.2, 0.4], [0.0, 0.01, -0.02, 0.03], [0.5, 0.5001]):
        expected = ttest_1samp(values, 0.0).confidence_interval(0.95)
        assert seed_interval(values) == pytest.approx((expected.low, expected.high), rel=1e-9)


def test_it_holds_the_true_mean_in_95_of_100_draws_of_three():
    draws = np.random.default_rng(0).normal(0.3, 0.02, (4000, 3))
    holds = [low <= 0.3 <= high for low, high in map(seed_interval, draws)]
    assert np.mean(holds) == pytest.approx(0.95, abs=0.015)


def test_one_seed_tells_nothing():
    assert seed_interval([0.07]) == (-1.0, 1.0)


def test_an_answer_stands_out_only_when_seeds_and_scenes_agree():
    def answer(question: str, seeds: tuple[float, float], scenes: tuple[float, float]) -> list[dict]:
        common = {"question": question, "difference": 0.04, "difference_interval": seeds, "scenes_interval": scenes}
        return [{**common, "metric": metric} for metric in METRICS]

    answers = [
        *answer("sure", (0.01, 0.07), (0.02, 0.06)),
        *answer("seeds differ", (-0.03, 0.11), (0.02, 0.06)),
        *answer("scenes differ", (0.01, 0.07), (-0.01, 0.09)),
    ]
    lines = {line.split(" | ")[0].strip("| "): line for line in as_markdown(answers).splitlines()}
    assert lines["sure"].count("**+4.0** [+1.0, +7.0]") == 2
    assert "**" not in lines["seeds differ"] + lines["scenes differ"]


def test_a_table_is_replaced_between_its_marks_only(tmp_path):
    path = tmp_path / "page.md"
    end = "<!-- end of table -->"
    path.write_text(f"before\n<!-- table: one -->\nold\n{end}\nbetween\n<!-- table: two -->\nkept\n{end}\n")
    replace_table(path, "one", "new")
    text = path.read_text()
    assert "old" not in text
    assert [word for word in text.split() if word in ("before", "new", "between", "kept")] == [
        "before",
        "new",
        "between",
        "kept",
    ]
    with pytest.raises(ValueError, match="three"):
        replace_table(path, "three", "new")


def test_the_p_value_is_that_of_the_t_test():
    for values in ([0.1, 0.2, 0.4], [0.0, 0.01, -0.02, 0.03], [0.5, 0.5001]):
        assert seed_p(values) == pytest.approx(ttest_1samp(values, 0.0).pvalue, rel=1e-9)
    assert seed_p([0.3]) == 1.0


def made_answers(draws: np.ndarray, scenes: tuple[float, float] = (0.01, 0.09)) -> list[dict]:
    return [
        {
            "question": f"does {number} help",
            "metric": "add_5pct",
            "difference": float(values.mean()),
            "difference_interval": seed_interval(values),
            "scenes_interval": scenes,
            "seeds": values.tolist(),
        }
        for number, values in enumerate(draws)
    ]


def test_chance_alone_rarely_answers_any_of_many_questions():
    rng = np.random.default_rng(1)
    wrong = [any(standing(made_answers(rng.normal(0.0, 0.02, (25, 8))))) for _ in range(400)]
    assert np.mean(wrong) < 0.08  # 72 % without the correction


def test_what_stands_is_said_and_nothing_else():
    rng = np.random.default_rng(2)
    draws = rng.normal(0.0, 0.01, (20, 8)) + np.array([0.05, -0.05, *[0.0] * 18])[:, None]
    answers = made_answers(draws)
    answers[1]["scenes_interval"] = (-0.08, -0.02)
    text = sentences(answers)
    assert "2 of 20 questions answered by 8 seeds" in text
    assert "does 0 help: yes, +" in text
    assert "does 1 help: no, it costs, -" in text
    assert text.count("does ") == 2
    # Where test scenes leave it open, it is left open.
    assert "no answer to any of the 20 questions" in sentences(made_answers(draws, (-0.01, 0.2)))
