import pytest

from footprints_edge.cli.doctor import advice, cpu_flags


def test_flags_of_x86_and_arm(tmp_path):
    cpuinfo = tmp_path / "cpuinfo"
    cpuinfo.write_text("processor\t: 0\nflags\t\t: fpu avx2 avx_vnni\n")
    assert cpu_flags(cpuinfo) == {"fpu", "avx2", "avx_vnni"}
    cpuinfo.write_text("processor\t: 0\nFeatures\t: fp asimd asimddp\n")
    assert cpu_flags(cpuinfo) == {"fp", "asimd", "asimddp"}
    assert cpu_flags(tmp_path / "nothing") == frozenset()


@pytest.mark.parametrize(
    ("precision", "flags", "word"),
    [
        ("int8", {"avx2"}, "x86-avx2"),
        ("int8", {"asimd"}, "dot product"),
        ("fp32", {"avx2", "avx_vnni"}, "int8 conversion"),
    ],
)
def test_advice(precision, flags, word):
    assert word in " ".join(advice(precision, frozenset(flags)))


def test_no_advice_about_instructions_where_all_is_well():
    text = " ".join(advice("int8", frozenset({"avx2", "avx512_vnni"})))
    assert "VNNI" not in text
