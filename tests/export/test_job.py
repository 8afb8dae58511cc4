"""What a conversion will write and look at is settled before it begins."""

import pytest

from footprints_edge_export.job import Job


@pytest.mark.parametrize(
    ("target", "precision", "has_ort"),
    [("x86-vnni", "fp32", False), ("mobile", "fp32", True), ("mobile", "fp16", False)],
)
def test_only_phones_get_an_ort_file_and_none_of_half_precision(
    conversion, tmp_path, target, precision, has_ort
):
    wanted = conversion(target=target, precision=precision)
    job = Job.checked(tmp_path / "a.pt", tmp_path / "a.onnx", wanted, overwrite=False)
    assert job.ort == (tmp_path / "a.ort" if has_ort else None)


def test_phones_get_a_size_where_none_is_named(conversion, tmp_path):
    for size, expected in ((None, (256, 448)), ((64, 96), (64, 96))):
        wanted = conversion(target="mobile", size=size)
        job = Job.checked(tmp_path / "a.pt", tmp_path / "a.onnx", wanted, overwrite=False)
        assert job.conversion.size == expected
        assert job.test_sizes == [expected]


def test_one_photo_in_five_is_held_out(conversion, photos, tmp_path):
    wanted = conversion(precision="int8", calibration=(photos,))
    job = Job.checked(tmp_path / "a.pt", tmp_path / "a.onnx", wanted, overwrite=False)
    assert (len(job.calibration), len(job.held_out)) == (8, 2)
    assert not set(job.calibration) & set(job.held_out)
    assert len(job.test_sizes) > 1
