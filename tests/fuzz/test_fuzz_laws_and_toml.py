"""Mutated laws, tables of measurements and TOML files: each is read, or refused in one line."""

import math
import random

import pytest

from hcsearch.scenes.laws import law_named
from hcsearch.springs.identification.measurements import read_accelerations, read_measured_moments
from hcsearch.system.reading import read_toml
from tests.fuzz.mutations import judge, mutated

LAWS = [
    *("free", "linear:0.1", "linear:0.1+0.02", "quadratic:0.02,0.03", "table:0@0,0.1@1.5,0.3@3.1", "table:law.csv"),
    *("tape:0.2@0.05,0.03@0.01", "2*linear:0.1", "3*2*tape:0.2@0.05,0.03@0.01-0.1", "table:/dev/zero", "table:\0.csv"),
    *(
        "1*" * 2000 + "linear:0.1",
        "1e308*linear:1e300",
        "table:-1e300@0,1e300@1e-9",
        "linear:1e300+1e300",
        "1e-308*free",
    ),
    *(
        "table:" + "11@11," * 1000 + "x",
        "table:" + ",".join(f"{k}@{k}" for k in range(2000)),
        "linear:\u0661",
        "linear:\ud800",
    ),
]
TABLES = [
    "angle_rad,moment_N_m\n0,0\n1.5,0.1\n3.1,0.3\n",
    "angle_deg,moment_N_mm\n" + "".join(f"{10 * k},{k * k}\n" for k in range(9)),
    "time_s,block_g\n" + "".join(f"{k / 100},{math.sin(k / 5):.4f}\n" for k in range(60)),
    "\ufeffangle_rad,moment_N_m\r\n0,0\r\n1e300,1e-300\r\n",
]
SCENES = [
    "design = 'hex:0234550132:4'\n[scene]\nspring = 'linear:0.1'\ngravity = [0, 0, -9.81]\nsprings = { 0 = 'free' }\n",
    "assembly = 'array-6r'\n[parameters]\nsize = '3x2'\nthickness = 6\n",
    "panel_mm = '50x50x6'\nmerge = true\nx = " + "[" * 2000 + "]" * 2000,
    "x = 1" + "0" * 5000,
    "x = 0x" + "f" * 5000 + "\ny = 1e999\nz = nan\nt = 1979-05-27T07:32:00Z\n",
]


def is_law(text):
    """Whether a text is a law; what is one has finite moments and energies between the stops, and reads itself."""

    def read(text):
        law = law_named(text)
        branches = [branch for branch in (law.straight, law.bent) if branch is not None]
        for angle in (0.0, 1.0, math.pi):
            assert all(math.isfinite(value) for b in branches for value in (b.moment(angle), b.energy(angle)))
        return law

    return judge(text, read, lambda law: law_named(law.text))


def is_file(text, folder):
    """How many readings take a text as a file."""
    path = folder / "file.csv"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    readings = (read_measured_moments, read_accelerations, lambda name: read_accelerations(name, 10.0, 1.0), read_toml)
    return sum(judge(str(path), read) for read in readings) + is_law(f"table:{path}")


def fuzz(seed, count, folder):
    """Judge so many mutations of both kinds; the numbers taken and refused."""
    (folder / "law.csv").write_text("angle_rad,moment_N_m\n0,0\n3.1,0.3\n")
    chance = random.Random(seed)
    numbers = [is_law(text) for text in LAWS] + [is_file(text, folder) for text in (*TABLES, *SCENES)]
    for _ in range(count):
        numbers.append(is_law(mutated(chance, chance.choice(LAWS))))
        numbers.append(is_file(mutated(chance, chance.choice((*TABLES, *SCENES))), folder))
    return sum(map(bool, numbers)), numbers.count(0)


def test_mutated_laws_and_files_are_read_or_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    taken, refused = fuzz(1, 250, tmp_path)
    assert taken > 50
    assert refused > 100


@pytest.mark.slow
def test_many_mutated_laws_and_files_are_read_or_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    taken, refused = fuzz(2, 2000, tmp_path)
    assert taken > 400
    assert refused > 1000
