"""`hcsearch identify` as a person meets it: files, tables, one clear line for what is wrong."""

import math
import re

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.scenes.laws import law_named
from hcsearch.springs.identification.measurements import read_accelerations, read_measured_moments
from hcsearch_bench.identification.rig import Rig, pairs


def run(*words):
    result = CliRunner().invoke(hcsearch, ["identify", *map(str, words)], catch_exceptions=True)
    assert result.exception is None, result.exception
    return result.output


def refused(*words):
    """The one line of an error."""
    result = CliRunner().invoke(hcsearch, ["identify", *map(str, words)])
    assert isinstance(result.exception, HcsearchError), result.output
    assert result.output == ""
    assert "\n" not in str(result.exception)
    return str(result.exception)


def write(path, heading, rows, digits=9):
    lines = [",".join(f"{value:.{digits}g}" for value in row) for row in rows]
    path.write_text("\n".join([heading, *lines]) + "\n", encoding="utf-8")
    return path


def write_test(path, seed, *, heading="time_s,block_g,frame_g", times=True, noise=0.01, rig=None):
    rig = rig or Rig()
    record = rig.record(noise, seed)
    columns = [np.arange(record.shape[1]) / rig.rate, *record] if times else record
    return write(path, heading, np.transpose(columns))


@pytest.mark.parametrize("angle", ["angle_rad", "angle_deg"])
@pytest.mark.parametrize("moment", ["moment_N_m", "moment_N_mm"])
def test_a_spring_in_any_unit(tmp_path, angle, moment):
    angles, moments = pairs(law_named("linear:0.1"), 0.0, 1)
    columns = np.transpose([np.degrees(angles) if "deg" in angle else angles, moments * (1e3 if "mm" in moment else 1)])
    output = run("spring", write(tmp_path / "spring.csv", f" {angle}, {moment}", columns))
    assert re.search(r"^law +linear:0.1$", output, re.MULTILINE)
    assert "156 loading, 156 unloading" in output
    assert output.count("chosen") == 1


def test_a_spring_with_other_columns_and_empty_lines(tmp_path):
    path = tmp_path / "spring.csv"
    rows = "\n\n".join(f"{0.1 * angle + 0.02},{angle},{20 + angle}" for angle in range(6))
    path.write_text(f"\ufeffmoment_N_m,angle_rad,kelvin\n{rows}\n", encoding="utf-8")
    output = run("spring", path)
    assert "linear:0.1+0.02" in output
    assert "one way only" in output


def test_several_tests_make_a_table_like_4_2(tmp_path):
    files = [write_test(tmp_path / f"test{k}.csv", k) for k in range(3)]
    output = run("damping", "--inertia", "0.0051", "--hinges", "4", *files)
    lines = output.splitlines()
    assert [line.split()[0] for line in lines[1:6]] == [*map(str, files), "average", "deviation"]
    rig = Rig()
    average = [float(number) for number in lines[4].split()[1:]]
    assert average == pytest.approx([rig.frequency, 2 * math.pi * rig.frequency, rig.ratio, rig.damping], rel=5e-3)
    assert "springs and weight: 1.2" in lines[6]
    assert re.search(r"% at 33\.\d+ Hz", lines[7])


def test_one_test_has_no_average_and_its_hinge_all_the_damping(tmp_path):
    output = run("damping", "--inertia", "0.0051", write_test(tmp_path / "test.csv", 1))
    assert len(output.splitlines()) == 4
    assert float(output.splitlines()[1].split()[-3]) == pytest.approx(4 * Rig().damping, rel=0.01)


def test_without_times_by_rate(tmp_path):
    path = write_test(tmp_path / "test.csv", 1, heading="block,frame", times=False)
    timed = write_test(tmp_path / "timed.csv", 1)
    by_rate = run("damping", "--inertia", "0.0051", "--rate", "200", path)
    assert (
        by_rate.replace(str(path), "").split()
        == run("damping", "--inertia", "0.0051", timed).replace(str(timed), "").split()
    )


def test_what_was_measured_before_is_left_out(tmp_path):
    record = Rig().record(0.002, 5)
    strike = np.concatenate([np.zeros((2, 60)), np.full((2, 5), 7.0), record], axis=1)
    timed = np.transpose([np.arange(strike.shape[1]) / 200.0, *strike])
    path = write(tmp_path / "raw.csv", "time_s,block_g,frame_g", timed)
    bare = write(tmp_path / "bare.csv", "block_g,frame_g", timed[:, 1:])
    for words in ((path,), ("--rate", "200", bare)):
        output = run("damping", "--inertia", "0.0051", "--hinges", "4", "--from", "0.325", *words)
        assert float(output.splitlines()[1].split()[-3]) == pytest.approx(Rig().damping, rel=0.01)


def test_times_of_few_digits_are_even(tmp_path):
    rig = Rig(rate=1024.0, seconds=1.0)
    times = np.round(np.arange(1024) / 1024.0, 4)
    path = write(tmp_path / "test.csv", "time_s,block", np.transpose([times, rig.record(0.0, 1)[0]]))
    records, rate = read_accelerations(str(path))
    assert records.shape == (1, 1024)
    assert rate == pytest.approx(1024.0, rel=1e-4)


MOMENTS = "angle_rad,moment_N_m\n"
TEST = "time_s,block\n"
EVEN = [f"{k / 100},{k % 7}" for k in range(100)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("angle_rad,moment\n0,1\n", "no columns of the moment .*angle_rad, moment.*: name one of them moment_N_m or"),
        ("angle,moment_N_m\n0,1\n", "no columns of the angle"),
        ("angle_rad,angle_deg,moment_N_m\n0,0,1\n", "2 columns of the angle"),
        ("0,1\n1,2\n", "first line .* names no columns"),
        ("angle_rad,angle_rad,moment_N_m\n0,0,1\n", "first line .* names no columns"),
        (MOMENTS + "0,0\n1,nan\n", "line 3 .* 'nan' for moment_N_m"),
        (MOMENTS + "0,0\n1,inf\n", "line 3 .* 'inf'"),
        (MOMENTS + "0,0\n1e-300,1\n", "line 3 .* '1e-300' for angle_rad: write 0 or a number of size 1e-30 to"),
        (MOMENTS + "0,0\n1,1e300\n", "line 3 .* '1e300' for moment_N_m"),
        (MOMENTS + "0,0\n1,x\n", "line 3 .* 'x' for moment_N_m"),
        (MOMENTS + "0,0\n1\n", "line 3 .* 1 values for 2 columns"),
        ("angle_rad;moment_N_m\n0;0,1\n", "not separated by commas"),
        ("angle_rad|moment_N_m\n0|0\n", "not separated by commas"),
        ("angle_rad moment_N_m\n0 0\n", "not separated by commas"),
        (MOMENTS + '0,0\n"1,5",1\n', "line 3 .* '1,5' for angle_rad: write decimals by points"),
        ("# by X\n" + MOMENTS + "0,0\n", "line 1 of .* names no columns, line 2 does: leave out what stands above it"),
        ("Test 12,\n\n% by X\n" + MOMENTS, "lines 1 to 3 of .* name no columns, line 4 does: leave out"),
        (MOMENTS, "0 different angles"),
        (MOMENTS + "0,0\n1,1\n2,2\n", "3 different angles"),
        (MOMENTS + "".join(f"{k},0.5\n" for k in range(6)), "0.5 N m at every angle"),
    ],
)
def test_wrong_moments_are_one_clear_line(tmp_path, text, message):
    path = tmp_path / "spring.csv"
    path.write_text(text, encoding="utf-8")
    assert re.search(message, refused("spring", path))


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (TEST + "\n".join([*EVEN[:50], "0.5,", *EVEN[51:]]), (), "line 52 .* '' for block: .* leave the column out"),
        (TEST + "\n".join([*EVEN[:50], ",1", *EVEN[51:]]), (), "line 52 .* '' for time_s"),
        ("time_s,note\n" + "\n".join(f"{k / 100},ok" for k in range(100)), (), "has no accelerations"),
        ("block\n" + "\n".join("12" * 50), (), "give the sampling rate by --rate"),
        ("block\n" + "\n".join("12" * 50), ("--rate", "0"), "sampling rate of 0 Hz"),
        ("time_s\n" + "\n".join(map(str, range(100))), (), "has no accelerations"),
        (TEST + "\n".join(EVEN[:20]), (), "20 samples"),
        (TEST + "\n".join(EVEN), ("--from", "0.9"), "10 samples"),
        (TEST + "\n".join(EVEN), ("--from", "9"), "0 samples"),
        ("block\n" + "\n".join("12" * 50), ("--rate", "1e300"), "sampling rate of 1e\\+300 Hz"),
        (TEST + "0,1\n", (), "has 1 rows"),
        (TEST + "\n".join(EVEN[::-1]), (), "sort the rows"),
        (TEST + "\n".join([*EVEN[:50], EVEN[49], *EVEN[50:]]), (), "0.49 s comes after 0.49 s"),
        (TEST + "\n".join(EVEN[:50] + EVEN[52:]), (), "not sampled evenly"),
        (TEST + "\n".join(f"{k / 100},0.3" for k in range(100)), (), "'block' .* is 0.3 all the time"),
        (TEST + "\n".join(f"{k / 100},{k}" for k in range(100)), (), "no decaying vibration"),
        (TEST + "\n".join(EVEN), ("--hinges", "0"), "0 hinges"),
        (TEST + "\n".join(EVEN), ("--hinges", "9" * 400), "999 hinges: give 1 to 1000"),
        (TEST + "\n".join(EVEN), ("--inertia", "-1"), "inertia of -1"),
    ],
)
def test_wrong_records_are_one_clear_line(tmp_path, text, options, message):
    path = tmp_path / "test.csv"
    path.write_text(text, encoding="utf-8")
    assert re.search(message, refused("damping", "--inertia", "0.0051", *options, path))


SWING = [(k, math.exp(-1.5 * k) * math.cos(15.6 * k)) for k in np.arange(800) / 400.0]


def swing(path, times, values=None, heading="time_s,block", line="{},{:.6f}"):
    """A file of a swing with times as texts."""
    values = [a for _, a in SWING] if values is None else values
    path.write_text("\n".join([heading, *(line.format(*row) for row in zip(times, values, strict=True))]) + "\n")
    return path


@pytest.mark.parametrize("rate", [80.0, 333.0, 400.0, 900.0, 1000.0])
@pytest.mark.parametrize("rounded", [lambda t: f"{t:.3f}", lambda t: f"{math.floor(1e3 * t + 1e-9) / 1e3:g}", repr])
def test_times_rounded_to_milliseconds_are_even(tmp_path, rate, rounded):
    records, found = read_accelerations(str(swing(tmp_path / "a.csv", [rounded(k / rate) for k in range(800)])))
    assert records.shape == (1, 800)
    assert found == pytest.approx(rate, rel=1e-4)


def test_times_that_may_be_milliseconds_are_doubted(tmp_path):
    path = swing(tmp_path / "a.csv", [f"{2.5 * k:.1f}" for k in range(800)])
    result = CliRunner().invoke(hcsearch, ["identify", "damping", "--inertia", "1", str(path)])
    assert result.exit_code == 0
    assert "one sample in 2.5 s: write seconds in time_s if these are milliseconds" in result.stderr


def test_times_of_six_digits_are_even(tmp_path):
    times = [f"{99.0 + k / 400.0:.6g}" for k in range(800)]
    assert read_accelerations(str(swing(tmp_path / "a.csv", times)))[1] == pytest.approx(400.0, rel=1e-5)


def test_a_rate_takes_the_place_of_times(tmp_path):
    path = swing(tmp_path / "a.csv", [f"{k / 400.0:.2f}" for k in range(800)])
    with pytest.raises(HcsearchError, match=r"rounded to 0\.01 s, more than a step: give the sampling rate by --rate"):
        read_accelerations(str(path))
    assert read_accelerations(str(path), 400.0)[1] == 400.0
    assert "2.500" not in refused("damping", "--inertia", "0.0051", path)
    assert re.search(r"2\.4\d\d \+-", run("damping", "--inertia", "0.0051", "--rate", "400", path))


@pytest.mark.parametrize("rate", [100.0, 400.0, 1000.0])
@pytest.mark.parametrize("digits", [3, 9])
@pytest.mark.parametrize(("gaps", "named"), [([(50, 1)], 1), ([(200, 2)], 1), ([(20, 10), (300, 1)], 2)])
def test_gaps_are_named_where_they_are(tmp_path, rate, digits, gaps, named):
    lost = {k for first, count in gaps for k in range(first, first + count)}
    kept = [k for k in range(800) if k not in lost]
    texts = [f"{k / rate:.{digits}f}" for k in kept]
    path = swing(tmp_path / "a.csv", texts, [SWING[k][1] for k in kept])
    message = refused("damping", "--inertia", "0.0051", path)
    assert "is not sampled evenly" in message
    places = [(first - 1, first + count) for first, count in gaps]
    for before, after in places:
        assert f"{float(f'{before / rate:.{digits}f}'):g} to {float(f'{after / rate:.{digits}f}'):g} s" in message
    assert message.count(" to ") == named
    after = f"{float(f'{places[-1][1] / rate:.{digits}f}'):g}"
    assert f"--from {after}" in message
    if len(kept) - places[-1][1] > 200:
        assert read_accelerations(str(path), start=float(after))[1] == pytest.approx(rate, rel=1e-4)


def test_a_gap_among_times_of_one_and_two_units_is_named_alone(tmp_path):
    times = [f"{k / 700:.3f}" for k in range(800) if k != 200]
    message = refused("damping", "--inertia", "0.0051", swing(tmp_path / "a.csv", times, [a for _, a in SWING[1:]]))
    assert "missing from 0.284 to 0.287 s, where a step is 0.003 s and not 0.00143 s" in message


@pytest.mark.parametrize(
    ("lost", "remedy"),
    [
        ({100}, r"begin after it by --from 1\.01$"),
        ({100, 120}, r"leave out what follows 0\.99 s$"),
        ({20, 120}, r"leave out what follows 1\.19 s and begin by --from 0\.21$"),
        ({50, 100}, r"measure anew: at most 50 samples follow each other, and 64 are needed$"),
    ],
)
def test_the_remedy_for_a_gap_leaves_enough_samples(tmp_path, lost, remedy):
    count = 166 if lost == {100} else 140
    kept = [k for k in range(count) if k not in lost]
    path = swing(tmp_path / "a.csv", [f"{k / 100:.2f}" for k in kept], [SWING[4 * k][1] for k in kept])
    assert re.search(remedy, refused("damping", "--inertia", "0.0051", path))
    if lost == {100}:
        assert read_accelerations(str(path), start=1.01)[0].shape == (1, 65)
        swing(path, [f"{1e5 + k / 100:.2f}" for k in kept], [SWING[4 * k][1] for k in kept])
        assert refused("damping", "--inertia", "0.0051", path).strip().endswith("--from 100001.01")


def test_a_gap_before_the_start_does_not_count(tmp_path):
    times, values = [k / 100 for k in range(400) if k != 50], [math.cos(k) for k in range(399)]
    path = swing(tmp_path / "a.csv", times, values)
    assert read_accelerations(str(path), start=0.51)[0].shape == (1, 349)


def test_columns_that_nobody_asked_for_are_left_out_with_a_line(tmp_path):
    rows = [(k, f"{t:.6f}", "struck" if k == 0 else "", f"{a:.6f}") for k, (t, a) in enumerate(SWING)]
    path = tmp_path / "a.csv"
    text = "\n".join(",".join(map(str, (*row, ""))) for row in rows)
    path.write_text(f"sample,time_s,remark,block,\n{text}\n")
    plain = swing(tmp_path / "plain.csv", [f"{t:.6f}" for t, _ in SWING])
    result = CliRunner().invoke(hcsearch, ["identify", "damping", "--inertia", "1", str(path)])
    expected = CliRunner().invoke(hcsearch, ["identify", "damping", "--inertia", "1", str(plain)])
    assert result.stdout.replace(str(path), "").split() == expected.stdout.replace(str(plain), "").split()
    assert "column 'remark' of" in result.stderr
    assert "column 'sample' of" in result.stderr
    assert result.stderr.count("is left out") == 2
    assert expected.stderr == ""
    path.write_text(f",time_s,,block,\n{text}\n")
    assert CliRunner().invoke(hcsearch, ["identify", "damping", "--inertia", "1", str(path)]).stderr == ""


ROWS = [(angle, 2.0 + 0.6 * angle + 0.008 * angle**2) for angle in range(0, 151, 15)]
BACK = [(angle, moment - 4.0) for angle, moment in ROWS[-2::-1]]


def moments(path, rows, heading="angle_deg,moment_N_mm", line="{},{:.1f}"):
    path.write_text("\n".join([heading, *(line.format(*row) for row in rows)]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("heading", "line"),
    [
        ("angle_deg,moment_N_mm,", "{},{:.1f},"),
        ("angle_deg,moment_N_mm", "{},{:.1f},,"),
        ("angle_deg,moment_N_mm,,", "{},{:.1f}"),
        ("\ufeff,angle_deg,moment_N_mm", "7,{},{:.1f}"),
        ("angle_deg,moment_N_mm,remark,remark", "{},{:.1f},ok,turned by hand"),
        ("angle_deg,remark,moment_N_mm", '{},"slack, once",{:.1f}'),
        ("Angle (°),Moment / N mm", "{},{:.1f}"),
    ],
)
def test_what_is_named_is_read_of_tables_as_people_write_them(tmp_path, heading, line):
    expected = run("spring", moments(tmp_path / "plain.csv", ROWS + BACK))
    assert "hysteresis    0.004 N m" in expected
    assert run("spring", moments(tmp_path / "spring.csv", ROWS + BACK, heading, line)) == expected


@pytest.mark.parametrize("cell", ["", "NaN", "n/a", "-", "#VALUE!", "inf"])
def test_a_row_without_a_value_is_to_be_left_out(tmp_path, cell):
    path = moments(tmp_path / "spring.csv", ROWS)
    lines = path.read_text().splitlines()
    lines[5] = f"60,{cell}"
    path.write_text("\n".join(lines))
    message = refused("spring", path)
    assert f"line 6 of {path} has {cell!r} for moment_N_mm: leave the row out" in message
    assert "write 0" not in message


@pytest.mark.parametrize(
    ("angle", "moment", "message"),
    [
        (-1, -1, r"angles from -2.618 to 0 rad, and hinges turn from 0 \(flat\) to pi: turn .* its angles and moments"),
        (-1, 1, r"hinges turn from 0 \(flat\) to pi: turn the sign of its angles$"),
        (1, -1, "turn the sign of its moments"),
    ],
)
def test_signs_that_no_hinge_has_are_refused(tmp_path, angle, moment, message):
    path = moments(tmp_path / "spring.csv", [(angle * a, moment * m) for a, m in ROWS + BACK])
    assert re.search(message, refused("spring", path))


@pytest.mark.parametrize(
    ("rows", "heading", "message"),
    [
        ([(150 - a, m) for a, m in ROWS], "angle_deg,moment_N_mm", "minus an angle that counts from the folded state"),
        ([*ROWS, *((a, m + 8.0) for a, m in BACK)], "angle_deg,moment_N_mm", "which no spring does: give the rows"),
        ([(0.9 * k, 0.1 * k) for k in range(6)], "angle_rad,moment_N_m", "from 0 to 4.5 rad, and hinges turn from 0"),
        ([(math.radians(a), m) for a, m in ROWS], "angle_deg,moment_N_mm", "name the column angle_rad if they are in"),
    ],
)
def test_what_no_spring_shows_is_said_in_one_line(tmp_path, rows, heading, message):
    path = moments(tmp_path / "spring.csv", rows, heading, "{},{:.4f}")
    result = CliRunner().invoke(hcsearch, ["identify", "spring", str(path)])
    assert result.exit_code == 0
    assert message in result.stderr
    assert len(result.stderr.splitlines()) == 1
    plain = moments(tmp_path / "plain.csv", ROWS + BACK)
    assert CliRunner().invoke(hcsearch, ["identify", "spring", str(plain)]).stderr == ""


def test_angles_from_the_folded_state_are_to_be_turned_and_moments_are_not(tmp_path):
    path = moments(tmp_path / "spring.csv", [(180 - a, m) for a, m in ROWS], "angle_deg,moment_N_mm")
    doubt = CliRunner().invoke(hcsearch, ["identify", "spring", str(path)]).stderr
    assert doubt.strip().endswith("write pi or 180 degrees minus an angle that counts from the folded state")


def test_degrees_that_are_named_rad_are_refused(tmp_path):
    path = moments(tmp_path / "spring.csv", ROWS, "angle_rad,moment_N_mm")
    assert re.search("an angle of 150 rad, .* name the column angle_deg", refused("spring", path))


def test_files_that_cannot_be_read(tmp_path):
    assert "No such file" in refused("spring", tmp_path / "none.csv")
    assert "Is a directory" in refused("damping", "--inertia", "1", tmp_path)
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00\x81")
    assert "is no text file" in refused("spring", tmp_path / "bytes.csv")
    with pytest.raises(HcsearchError, match="No such file"):
        read_measured_moments(str(tmp_path / "none.csv"))
    assert "it is a pipe or a device" in refused("spring", "/dev/zero")


def test_files_with_strange_names_are_shown_by_escapes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_test(tmp_path / "a\x1b[31m.csv", 1)
    output = run("damping", "--inertia", "0.0051", "a\x1b[31m.csv")
    assert "\x1b" not in output
    assert "a\\x1b[31m.csv " in output


@pytest.mark.parametrize("option", ["--inertia", "--rate", "--from"])
@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_numbers_are_finite(option, value):
    result = CliRunner().invoke(hcsearch, ["identify", "damping", "--inertia", "1", option, value, "a.csv"])
    assert result.exit_code == 2
    assert f"{value} is not a finite number" in result.output


def test_a_start_that_is_no_time_is_refused(tmp_path):
    path = write_test(tmp_path / "a.csv", 1)
    with pytest.raises(HcsearchError, match="a start at nan s"):
        read_accelerations(str(path), start=math.nan)


@pytest.mark.parametrize("command", ["spring", "damping"])
def test_help_has_an_example(command):
    result = CliRunner().invoke(hcsearch, ["identify", command, "--help"])
    assert result.exit_code == 0
    assert f"Example: hcsearch identify {command}" in " ".join(result.output.split())
