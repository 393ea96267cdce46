"""Films of a deployment: reading, fits, intervals, what is not explained; and the command as a person meets it."""

import json
import math
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from hcsearch import deploy, identify_motion
from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.scenes import Scene
from hcsearch.scenes.scene_file import scene_in
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.identification.identified_motion import scene_lines, scene_values
from hcsearch.springs.identification.measured_films import Film, course_of, film_noise, read_film
from hcsearch.springs.identification.motion_adequacy import coordinate_errors, estimates_of, left_over
from hcsearch.springs.identification.motion_fitting import FilmProblem, FittedFilms, fit_films
from hcsearch.springs.identification.motion_parameters import motion_parameters, nearest_axis, tilted, tilts_of
from hcsearch_bench.identification.film_rows import CASES, FILM_NOISE, measure_films
from tests.linkages import linkage_named

NAME = "hex:0234550132:4"
LINKAGE = linkage_named(NAME)
HINGES = labels_of(LINKAGE).hinges
TRUE = Scene(spring="linear:0.13", damping=0.006)


def film_of(scene, seed=0, *, noise=FILM_NOISE, frames=80, seconds=0.2, release=0.01):
    times = np.arange(frames) * seconds / frames
    angles = course_of(LINKAGE, setup_of_scene(scene, LINKAGE), seconds).at(times - release)
    return Film("film", times, angles + noise * np.random.default_rng(seed).standard_normal(angles.shape))


def write(path, film, *, hinges=HINGES, unit="deg"):
    scale = 180.0 / math.pi if unit == "deg" else 1.0
    columns = [HINGES.index(name) for name in hinges]
    lines = [",".join(["time_s", *(f"{name}_{unit}" for name in hinges)])]
    for time, row in zip(film.times, film.angles[:, columns] * scale, strict=True):
        lines.append(",".join([f"{time:.6f}", *("" if math.isnan(x) else f"{x:.4f}" for x in row)]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def run(*words, code=0):
    result = CliRunner().invoke(hcsearch, ["identify", "motion", *map(str, words)])
    assert result.exit_code == code, (result.output, result.exception)
    return result.output


@pytest.mark.parametrize("unit", ["deg", "rad"])
def test_a_film_has_columns_by_hinge_and_unit_and_may_have_gaps(tmp_path, unit):
    film = film_of(TRUE)
    film.angles[3, 0] = math.nan
    read = read_film(str(write(tmp_path / "a.csv", film, hinges=HINGES[:3], unit=unit)), labels_of(LINKAGE))
    assert read.times == pytest.approx(film.times)
    assert read.angles[:, :3] == pytest.approx(film.angles[:, :3], abs=1e-4, nan_ok=True)
    assert np.isnan(read.angles[:, 3:]).all()
    assert read.n_angles == 3 * len(film.times) - 1


def test_the_states_of_a_deployment_are_a_film(tmp_path):
    deployed = deploy(NAME)
    deployed.table().to_csv(tmp_path / "motion.csv", index=False)
    notes = []
    film = read_film(str(tmp_path / "motion.csv"), labels_of(LINKAGE), rate=1000.0, note=notes.append)
    assert film.angles == pytest.approx(deployed.deployment.angles)
    assert film.times[1] == 0.001
    assert "rate_0_rad_s" in notes[0] or "kinetic_J" in notes[0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,speed\n0,1\n", "has no fold angles: name a column by hinge and unit, such as 7_deg"),
        ("time_s,99_deg\n0,1\n", "there is no hinge 99"),
        ("time_s,7_deg,7_rad\n0,1,1\n", "gives hinge 7 twice"),
        ("7_deg\n1\n2\n", "has no column time_s: add one, or give the frames by --rate HZ"),
        ("time_s,7_deg\n0,x\n", "leave the cell empty where nothing was measured"),
        ("time_s,7_rad\n0,170\n", "reaches 170, more than a turn"),
        ("time_s,7_deg\n" + "".join(f"{k},1\n" for k in range(5)), "has 5 frames with an angle: give 8 or more"),
        ("time_s,7_deg\n0,1\n0,2\n", "0 s comes after 0 s"),
    ],
)
def test_wrong_films_are_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(HcsearchError, match=message) as caught:
        read_film(str(path), labels_of(LINKAGE))
    assert "\n" not in str(caught.value)


def test_before_the_release_nothing_moves_and_after_the_flat_state_angles_only_shrink():
    course = course_of(LINKAGE, setup_of_scene(Scene(), LINKAGE), 0.3)
    end = float(course.motion.times[-1])
    assert course.motion.ending == "flat"
    angles = course.at(np.array([-1.0, 0.0, end, end + 1e-9, end + 0.05, end + 1.0]))
    assert (angles[0] == angles[1]).all()
    assert angles[3] == pytest.approx(angles[2], abs=1e-6)
    assert (np.abs(angles[4]) <= np.abs(angles[2]) + 1e-15).all()
    assert np.abs(angles).max(axis=1)[4:].max() <= 0.01 + 1e-9


@given(noise=st.floats(1e-3, 0.05), seed=st.integers(0, 100))
def test_noise_is_estimated_from_neighbouring_frames(noise, seed):
    times = np.sort(np.random.default_rng(seed).uniform(0.0, 1.0, 400)) + 1e-3 * np.arange(400)
    angles = np.outer(np.sin(3.0 * times), np.ones(4))
    film = Film("film", times, angles + noise * np.random.default_rng(seed + 1).standard_normal(angles.shape))
    assert film_noise([film])[0] == pytest.approx(noise, rel=0.25)


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.integers(0, 5))
def test_tilts_are_those_of_the_gravity_that_they_make(first, second, axis):
    gravity = tilted(9.81, axis, (first, second))
    assert math.hypot(*gravity) == pytest.approx(9.81)
    assert tilts_of(gravity, axis) == pytest.approx((first, second), abs=1e-9)
    if math.hypot(first, second) < 0.7:
        assert nearest_axis(gravity) == axis


def test_white_residuals_are_noise_and_waves_are_not():
    times = np.linspace(0.0, 1.0, 200)
    random = np.random.default_rng(1)
    noise = 0.02 * random.standard_normal((200, 3))
    film = Film("film", times, np.sin(times)[:, None] + noise)
    left = left_over([film], -noise.ravel(), 599)
    assert left.explained
    assert left.noise == pytest.approx(0.02, rel=0.2)
    wave = np.zeros((200, 3))
    wave[:, 1] = 0.06 * np.exp(-(((times - 0.3) / 0.05) ** 2))
    off = left_over([film], (wave - noise).ravel(), 599)
    assert not off.explained
    assert (off.film, off.hinge) == (0, 1)
    assert off.time == pytest.approx(0.3, abs=0.05)
    assert off.error == pytest.approx(0.06, abs=0.02)
    assert off.misfit == pytest.approx(math.sqrt((wave**2).mean()), rel=0.2)


def test_parameters_that_move_films_alike_are_not_identified():
    parameters = motion_parameters(LINKAGE, setup_of_scene(Scene(), LINKAGE), ("stiffness", "damping", "friction"))
    random = np.random.default_rng(2)
    slopes = random.standard_normal((100, 4))
    slopes[:, 1] = 3.0 * slopes[:, 0]
    fit = FittedFilms(parameters, np.zeros(3), np.zeros(1), random.standard_normal(100), slopes)
    errors, identified = coordinate_errors(fit)
    assert identified.tolist() == [False, False, True]
    variance = fit.squares / fit.freedom * np.linalg.inv(slopes[:, 1:].T @ slopes[:, 1:])[1, 1]
    assert errors[2] == pytest.approx(math.sqrt(variance))


def test_exact_films_give_the_parameters_that_made_them():
    film = film_of(replace(TRUE, friction=0.01), noise=0.0)
    setup = setup_of_scene(Scene(), LINKAGE)
    parameters = motion_parameters(LINKAGE, setup, ("stiffness", "damping", "friction"))
    start = FilmProblem(LINKAGE, parameters, [film]).solve(np.array([0.2, 1.2, 0.3]), np.array([0.012]))
    values = [one.value(x) for one, x in zip(start.parameters.parameters, start.x, strict=True)]
    assert values == pytest.approx([0.13, 0.006, 0.01], rel=1e-4)
    assert start.releases[0] == pytest.approx(0.01, abs=1e-6)


def test_friction_that_is_not_there_has_an_interval_from_0_on():
    film = film_of(TRUE, 3)
    setup = setup_of_scene(replace(TRUE, spring="linear:0.12"), LINKAGE)
    fit = fit_films(LINKAGE, motion_parameters(LINKAGE, setup, ("stiffness", "friction")), [film])
    stiffness, friction = estimates_of(FilmProblem(LINKAGE, fit.parameters, [film]), fit)
    assert stiffness.low < 0.13 < stiffness.high
    assert friction.low == 0.0
    assert 0.0 <= friction.value < friction.high < 0.01
    # the profile: with friction held at the upper end, the squares are those of the confidence
    held = FilmProblem(LINKAGE, fit.parameters, [film])
    at = fit.x.copy()
    at[1] = friction.high / fit.parameters.parameters[1].scale
    worse = held.solve(at, fit.releases, fixed=1).squares
    assert worse == pytest.approx(fit.squares * (1.0 + 1.96**2 / fit.freedom), rel=2e-4)


def test_values_are_those_of_a_scene_file():
    setup = setup_of_scene(Scene(), LINKAGE)
    fitted = motion_parameters(LINKAGE, setup, ("stiffness", "damping", "gravity", "drag"))
    x = np.array([0.1, 1.5, 0.2, -0.3, 0.01])
    values = scene_values(LINKAGE, fitted, fitted.setup_at(x), x)
    scene = scene_in(tomllib.loads(scene_lines(values)))
    again = setup_of_scene(scene, LINKAGE)
    true = fitted.setup_at(x)
    assert again.laws[0].straight.moment(1.0) == pytest.approx(true.laws[0].straight.moment(1.0), rel=1e-5)
    assert (*again.dampings, again.drag) == pytest.approx((*true.dampings, true.drag), rel=1e-5)
    assert again.gravity == pytest.approx(true.gravity, rel=1e-5)
    single = motion_parameters(LINKAGE, setup, ("stiffness-by-hinge",))
    at = 0.1 * np.arange(len(HINGES))
    springs = scene_in(tomllib.loads(scene_lines(scene_values(LINKAGE, single, single.setup_at(at), at)))).springs
    assert [name for name, _ in springs] == list(HINGES)


def test_the_command_explains_a_film_and_predicts_another(tmp_path):
    paths = [write(tmp_path / f"{name}.csv", film_of(TRUE, k)) for k, name in enumerate("ab")]
    words = (paths[0], NAME, "--fit", "stiffness,damping", "--held-out", paths[1])
    output = run(*words)
    assert output.startswith("verdict       explained to 1.8 degrees rms")
    assert "stiffness, damping" in output
    assert "chosen, explains" in output
    assert "b.csv, released at 0.0" in output
    assert "predicted" in output
    assert '[scene]\nspring = "linear:0.1' in output
    facts = json.loads(run(*words, "--json"))
    stiffness, damping = facts["parameters"]
    assert stiffness["low"] < 0.13 < stiffness["high"]
    assert damping["low"] < 0.006 < damping["high"]
    assert facts["verdict"] == "explained"
    assert facts["films"][0]["release_s"] == pytest.approx(0.01, abs=0.002)
    assert facts["held_out"][0]["predicted"]
    assert facts["left"]["noise_rad"] == pytest.approx(FILM_NOISE, rel=0.1)
    assert [row["terms"] for row in facts["tried"]][:2] == [[], ["stiffness"]]


def test_what_nothing_fits_is_not_explained(tmp_path):
    path = write(tmp_path / "drag.csv", film_of(replace(TRUE, drag=60.0), 1, seconds=0.3))
    output = run(path, NAME, "--fit", "stiffness,damping", code=1)
    assert re.search(r"not explained: \d.* degrees rms remain that are no noise, most in hinge \d+ at 0\.\d+ s", output)
    identified = identify_motion([str(path)], NAME, fit=("stiffness", "damping", "drag"))
    assert identified.explained
    drag = next(one for one in identified.estimates if one.name == "drag")
    assert drag.low < 60.0 < drag.high


def test_wrong_words_are_refused(tmp_path):
    path = write(tmp_path / "a.csv", film_of(TRUE))
    assert "'speed' is no term: choose from stiffness" in run(path, NAME, "--fit", "speed", code=2)
    for fit, message in (
        (("stiffness", "stiffness-by-hinge"), "springs are fitted by stiffness or by stiffness-by-hinge, not both"),
        ((), "there is nothing to fit"),
    ):
        with pytest.raises(HcsearchError, match=message):
            identify_motion([str(path)], NAME, fit=fit)
    with pytest.raises(HcsearchError, match="the scene has no spring to fit"):
        identify_motion([str(path)], NAME, fit=("stiffness",), spring="free")


@pytest.mark.slow
def test_intervals_hold_the_planted_values_in_90_of_100_films():
    verdict, rows = measure_films("friction", range(100), say=lambda _: None)
    assert verdict.explained >= 95
    for row in rows:
        assert row.within >= 90, row


@pytest.mark.slow
def test_planted_drag_is_refused_without_drag():
    verdict, _ = measure_films("drag", range(3), without="drag", say=lambda _: None)
    assert verdict.explained == 0


def test_the_planted_values_of_the_bench_are_named_as_parameters():
    for name, case in CASES.items():
        start = case.case({})
        fitted = motion_parameters(start.linkage, start.setup, case.terms).parameters
        assert set(case.truths) <= {one.name for one in fitted}, name


@pytest.mark.parametrize("term", ["friction", "damping"])
def test_values_of_single_hinges_are_not_fitted_as_one(tmp_path, term):
    path = write(tmp_path / "film.csv", film_of(TRUE))
    with pytest.raises(HcsearchError, match=f"{term} is fitted as one of all hinges"):
        identify_motion([path], NAME, fit=("stiffness", term), hinges={"3": {term: 0.02}})


def test_films_of_strong_dampers_are_simulated_to_their_end():
    course = course_of(LINKAGE, setup_of_scene(Scene(damping=1.0), LINKAGE), 40.0)
    assert (course.motion.ending, course.motion.method) == ("rest", "implicit")
    compared = deploy(NAME, damping=1.0, seconds=40.0, tolerance=1e-8).deployment.motion
    assert (course.motion.q == compared.q).all()
