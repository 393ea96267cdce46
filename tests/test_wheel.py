"""The built package, installed without its sources beside it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder into which a wheel of this checkout is installed, without what it depends on."""
    place = tmp_path_factory.mktemp("wheel")
    source, site = place / "source", place / "site"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for name in ("hcsearch", "hcsearch_bench"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", str(place), str(source)], check=True)
    (wheel,) = place.glob("*.whl")
    ZipFile(wheel).extractall(site)
    return site


def run(site, folder, *words):
    """A command of the installed package alone, from another folder."""
    code = "import sys; sys.argv[0] = 'hcsearch'; from hcsearch.__main__ import main; main()"
    command = [sys.executable, "-c", code, *words]
    done = subprocess.run(
        command, cwd=folder, env=os.environ | {"PYTHONPATH": str(site)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_commands_of_a_wheel_run_in_another_folder(site, tmp_path):
    assert "deployed by springs" in run(site, tmp_path, "enumerate", "--grid", "hex", "--n", "6", "--db", "all.sqlite")
    run(site, tmp_path, "report", "--db", "all.sqlite", "--output", "all.html")
    assert "<svg" in (tmp_path / "all.html").read_text()
    run(site, tmp_path, "bench", "mobility", "--quick", "--output", "bench")
    assert (tmp_path / "bench" / "mobility.md").exists()


@pytest.mark.slow
def test_a_wheel_is_found_before_the_checkout(site, tmp_path):
    where = "import hcsearch, hcsearch_bench; print(hcsearch.__file__, hcsearch_bench.__file__)"
    command = [sys.executable, "-c", where]
    shown = subprocess.run(command, cwd=tmp_path, env={"PYTHONPATH": str(site)}, capture_output=True, check=True)
    assert shown.stdout.decode().split() == [
        str(site / name / "__init__.py") for name in ("hcsearch", "hcsearch_bench")
    ]


@pytest.mark.slow
def test_a_wheel_holds_envelopes_and_the_rules_of_standards(site):
    data = [file.relative_to(ROOT) for file in (ROOT / "hcsearch").rglob("*.toml")]
    assert len(data) >= 3
    assert all((site / file).read_bytes() == (ROOT / file).read_bytes() for file in data)


@pytest.mark.slow
def test_a_wheel_of_sources_without_git_has_a_version(site, tmp_path):
    (info,) = site.glob("*.dist-info")
    assert run(site, tmp_path, "--version") == f"hcsearch, version {info.stem.partition('-')[2]}\n"


@pytest.mark.slow
def test_a_wheel_names_both_licences_and_holds_their_texts(site):
    (info,) = site.glob("*.dist-info")
    metadata = (info / "METADATA").read_text(encoding="utf-8").splitlines()
    assert "License-Expression: MIT AND Unlicense" in metadata
    named = [line.partition(": ")[2] for line in metadata if line.startswith("License-File: ")]
    assert named == ["LICENSE", "hcsearch/web/player/js/LICENSE-ogl.txt"]
    for name in named:
        assert (info / "licenses" / name).read_bytes() == (ROOT / name).read_bytes()
