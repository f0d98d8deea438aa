"""Options of a compiler from a file of another maker: what is harmless is used, all else is named and left out."""

from __future__ import annotations

import pytest

from fmus.reading.build_options import harmless


@pytest.mark.parametrize(
    "option",
    [
        *("-O3", "-g", "-std=c99", "-std=gnu++17", "-Wall", "-Wno-unused-parameter", "-fno-strict-aliasing", "-fPIC"),
        *("-ffast-math", "-fwrapv", "-fopenmp", "-pthread", "-march=native", "-mavx2", "-ffp-contract=off"),
        *("-DFMI2", "-DX=1", '-DNAME="a b"', "-DF(x)=x", "-UX", "-Iinclude", "-I.", "-Ia/../b", "-lblas", "-lstdc++"),
    ],
)
def test_what_says_how_c_is_translated_is_used(option):
    assert harmless([option]).used == (option,)


@pytest.mark.parametrize(
    "option",
    [
        *(
            "-fplugin=x.so",
            "-fplugin-arg-x=y",
            "-o",
            "-ox.c",
            "-specs=x",
            "--specs=x",
            "-wrapper",
            "@file",
            "-B.",
            "-I/",
        ),
        *(
            "-I../..",
            "-I..\\..",
            "-I",
            "-include",
            "/etc/passwd",
            "-imacros",
            "-isystem",
            "-iquote/etc",
            "-Wl,-rpath,/x",
        ),
        *("-Wa,-al", "-Wp,-MD,x", "-fdump-tree-all", "-fprofile-generate", "-fprofile-use=/x", "-fsanitize=address"),
        *(
            "-save-temps",
            "-MD",
            "-MF",
            "-dumpdir",
            "-x",
            "-Xlinker",
            "-T/x",
            "-l:x.so",
            "-l../x",
            "-L/x",
            "-D1",
            "-DX=a\nb",
        ),
        *("-fuse-ld=/x", "-static", "-nostdlib", "-E", "-S", "-c", "-###", "-pipe;x", "", "x.c", "-D" + "x" * 20_000),
        *("-mllvm", "-fmodules-cache-path=/x", "-fstack-usage", "-ftest-coverage", "--coverage", "-fcallgraph-info"),
    ],
)
def test_what_could_write_load_or_run_something_is_left_out(option):
    assert harmless([option]).left_out == (option,)


def test_the_order_stays():
    found = harmless(["-O2", "-o", "-DX", "-fplugin=y", "-lm"])
    assert (found.used, found.left_out) == (("-O2", "-DX", "-lm"), ("-o", "-fplugin=y"))
