"""Files and neighbours that mean harm: nothing of a person's is read, written, removed or executed for them."""

from __future__ import annotations

import json
import os
import re
import shutil
import stat
import time
import zipfile
from pathlib import Path

from fmus.toolchain.version import Version
from tests.faults.commands import LASTS, Started
from tests.faults.scoring import fault
from tests.fmus.foreign import description2, description3, library, pack, scalar
from tests.orchestrator import ssps

GROUP = "security"
Y3 = ['<Float64 name="y" valueReference="101" causality="output"/>']
S3 = ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>']
SOURCES = '<SourceFiles><File name="a.c"/></SourceFiles>'
OUTSIDE = "/tmp/evil"  # noqa: S108 - where nothing may be written
TOUCHES = (
    "#include <fcntl.h>\n"
    '__attribute__((constructor)) static void touch() { open("MARK", O_CREAT | O_WRONLY, 0644); }\n'
    '#include "echo3.c"'
)


def typed(folder, *arguments):
    return Started(folder, *arguments).end()


def simple(folder, name="m.fmu", source='#include "echo3.c"', **files):
    built = library(folder / "made", Version.FMI3, source)
    return pack(folder / name, Version.FMI3, description3(Y3, S3), built, **files)


@fault(GROUP, "Python files in the working folder")
def python_files(folder, _):
    simple(folder)
    for name in ("queue", "statistics", "fmpy", "numpy", "json", "casadi", "typer", "sitecustomize"):
        (folder / f"{name}.py").write_text("open('executed', 'a').write(__name__)")
    (folder / "fmus").mkdir()
    (folder / "fmus" / "__init__.py").write_text("open('executed', 'a').write(__name__)")
    (folder / "matplotlibrc").write_text("backend: module://queue\n")
    assert typed(folder, "check", "m.fmu")[0] == 0
    assert typed(folder, "run", "m.fmu", "--stop-time", 1, "--step", 0.1)[0] == 0
    assert typed(folder, "run", "static", "--blocks", "--stop-time", 1)[0] == 0
    assert not (folder / "executed").exists()


@fault(GROUP, "--out names a folder with a person's files and a system.ssp")
def persons_folder(folder, _):
    mine = folder / "mine"
    (mine / ".git").mkdir(parents=True)
    for name in ("system.ssp", "main.c", ".git/HEAD", "summary.json"):
        (mine / name).write_text("mine")
    code, said = typed(folder, "run", "idle", "--blocks", "--out", "mine")
    assert code == 2, said
    assert {p.read_text() for p in mine.rglob("*") if p.is_file()} == {"mine"}


@fault(GROUP, "a stranger's manifest lists a person's files")
def strangers_manifest(folder, _):
    assert typed(folder, "run", "idle", "--blocks", "--out", "r")[0] == 0
    kept = [folder / "r" / "notes.txt", folder / "outside.txt"]
    for path in kept:
        path.write_text("mine")
    manifest = folder / "r" / "manifest.json"
    text = manifest.read_text("utf-8")
    assert "summary.json" in text
    for name in ("notes.txt", "../outside.txt", str(folder / "outside.txt")):
        manifest.write_text(text.replace("summary.json", name), "utf-8")
        typed(folder, "run", "idle", "--blocks", "--out", "r")
        manifest.write_text(text, "utf-8")
    assert [path.read_text() for path in kept] == ["mine", "mine"]


def named(name):
    def check(folder, _):
        text = description2(
            [scalar("y", 101, "output")],
            interface=f'<CoSimulation modelIdentifier="{name}">{SOURCES}</CoSimulation>',
        )
        pack(folder / "deep" / "er" / "m.fmu", Version.FMI2, text, None, sources__a_txt="")
        with zipfile.ZipFile(folder / "deep" / "er" / "m.fmu", "a") as archive:
            archive.writestr("sources/a.c", "int fmi2GetVersion() { return 0; }")
        before = outside(folder)
        for arguments in (("check", "m.fmu"), ("run", "m.fmu", "--stop-time", 1, "--step", 0.1)):
            code, said = typed(folder / "deep" / "er", *arguments)
            assert code in {1, 2}, said
        assert outside(folder) == before

    return check


def outside(folder):
    """The files that an FMU may not make: beside it, above it, and in the folder for temporary files itself."""
    names = {str(path) for path in folder.rglob("*") if "made" not in path.parts and "runs" not in path.parts}
    return names, {path.name for path in Path(OUTSIDE).parent.glob("*evil*")}


for hostile in ("../../evil", OUTSIDE, "..\\..\\evil", "a/../../../evil", "e" * 5000):
    fault(GROUP, f"a modelIdentifier {hostile[:20]} with sources", short=hostile == "../../evil")(named(hostile))


def leaving(kind):
    def check(folder, _):
        simple(folder)
        if kind == "ssp":
            ssps.write(folder / "m.ssp", ssps.body("", ""), {})
        for name in ("../evil.txt", f"{OUTSIDE}.txt", "resources/../../evil.txt", "..\\evil.txt"):
            path = folder / f"hostile.{kind}"
            shutil.copyfile(folder / f"m.{kind}", path)
            with zipfile.ZipFile(path, "a") as archive:
                archive.writestr(name, "evil")
            code, said = typed(folder, "check", path)
            assert code in {1, 2}, said
            assert "leave" in said, said
        assert not list(folder.rglob("evil*"))
        assert not Path(f"{OUTSIDE}.txt").exists()

    return check


for kind in ("fmu", "ssp"):
    fault(GROUP, f"entries that leave the folder, in an .{kind}", short=False)(leaving(kind))


@fault(GROUP, "an XML entity that reads a file")
def entity(folder, _):
    (folder / "secret.txt").write_text("the secret")
    simple(folder)
    text = description3(Y3, S3).replace("?>", f'?><!DOCTYPE d [<!ENTITY e SYSTEM "file://{folder}/secret.txt">]>', 1)
    pack(folder / "h.fmu", Version.FMI3, text.replace('name="y"', 'name="y" description="&e;"'), None)
    code, said = typed(folder, "check", "h.fmu")
    assert code == 1, said
    assert "DTD" in said
    assert "secret" not in said.replace("secret.txt", "")


@fault(GROUP, "sources of an SSP outside it", short=False)
def sources_outside(folder, _):
    inner = simple(folder)
    for uri in ("../m.fmu", f"file://{inner}", str(inner), "http://127.0.0.1:9/m.fmu", "resources/../../m.fmu"):
        element = ssps.component("a", "x.fmu", ssps.connectors("y:output")).replace("resources/x.fmu", uri)
        assert uri in element
        ssps.write(folder / "s.ssp", ssps.body(element, ""), {})
        code, said = typed(folder, "run", "s.ssp", "--stop-time", 1, "--step", 0.1)
        assert code == 2, (uri, said)


@fault(GROUP, "check --static of an FMU whose library acts when it is loaded")
def static_check(folder, _):
    mark = folder / "acted"
    simple(folder, source=TOUCHES.replace("MARK", str(mark)))
    assert typed(folder, "check", "--static", "m.fmu")[0] == 0
    assert not mark.exists()
    assert typed(folder, "check", "m.fmu")[0] == 0
    assert mark.exists(), "the fault is not done"


@fault(GROUP, "markup and escape sequences in names and messages")
def terminal(folder, _):
    hostile = "[/red] [link=x]y \u009b31m \u202e"
    y = [f'<Float64 name="y" valueReference="101" causality="output" description="{hostile}" quantity="{hostile}"/>']
    log = r'log(env, fmi3Error, "error", "a[/b]\x1b[2J\x1b]0;t\x07"); return NULL;'
    built = library(folder / "made", Version.FMI3, f'#define EXTRA {log}\n#include "echo3.c"')
    pack(folder / "m.fmu", Version.FMI3, description3(y, S3), built)
    for arguments in (("check", "m.fmu"), ("run", "m.fmu", "--stop-time", 1, "--step", 0.1, "--out", "r")):
        run = Started(folder, *arguments)
        out, said = run.process.communicate(timeout=300)
        assert run.process.returncode in {1, 2}
        assert "Traceback" not in said, said
        assert not {"\x1b", "\x9b", "\x07", "\u202e"} & {*out, *said}, (out, said)
        assert "a[/b]" in out + said


@fault(GROUP, "temporary files while it runs are for their owner alone", short=False)
def private(folder, _):
    place = folder / "tmp"
    place.mkdir()
    run = Started(folder, *LASTS, "--out", "r", env={**os.environ, "TMPDIR": str(place)})
    run.wait_for("r/recording.rrd")
    time.sleep(0.5)
    found = list(place.iterdir())
    assert found
    assert all(stat.S_IMODE(path.stat().st_mode) & 0o077 == 0 for path in found)
    assert run.end()[0] == 0
    assert not list(place.iterdir())


@fault(GROUP, "a name in an SSP that leads out of runs/", short=False)
def hostile_name(folder, _):
    simple(folder)
    element = ssps.component("a", "m.fmu", ssps.connectors("y:output"))
    ssps.write(folder / "s.ssp", ssps.body(element, ""), {"resources/m.fmu": folder / "m.fmu"})
    with zipfile.ZipFile(folder / "s.ssp") as archive:
        texts = {name: archive.read(name) for name in archive.namelist()}
    text = texts["SystemStructure.ssd"].decode()
    for name in ("../../evil", OUTSIDE, "..", "con", "e" * 3000):
        head, _, rest = text.partition("<ssd:System ")
        changed = re.sub(' name="[^"]*"', f' name="{name}"', head, count=1)
        with zipfile.ZipFile(folder / "h.ssp", "w") as archive:
            for entry, content in texts.items():
                archive.writestr(entry, f"{changed}<ssd:System {rest}" if entry.endswith(".ssd") else content)
        code, said = typed(folder, "run", "h.ssp", "--stop-time", 1, "--step", 0.1)
        assert code in {0, 2}, (name, said)
    assert not list(folder.glob("evil*"))
    assert {path.name for path in folder.iterdir()} <= {"made", "m.fmu", "s.ssp", "h.ssp", "runs"}
    for summary in folder.rglob("summary.json"):
        assert json.loads(summary.read_text("utf-8"))["status"] == "finished"
