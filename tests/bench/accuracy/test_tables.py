"""Tables of scores."""

from footprints_edge_bench.accuracy.summary import ScoreSummary
from footprints_edge_bench.accuracy.tables import tables


def test_the_best_is_bold_and_the_second_underlined():
    def row(iou, a1, rmse):
        means = dict.fromkeys(("f1", "precision", "recall"), iou) | {"iou": iou}
        depth = {"a1": a1, "rmse": rmse, "abs_rel": rmse, "sq_rel": rmse}
        return {
            "freespace": ScoreSummary(3, means, means),
            "ground_depth": ScoreSummary(3, depth, {}),
        }

    text = tables({"x": row(0.5, 0.2, 1), "y": row(0.7, 0.3, 3), "z": row(0.6, 0.1, 2)})
    assert "| y | **0.700** | **0.700** |" in text
    assert "| z | <u>0.600</u> | <u>0.600</u> |" in text
    assert "| x | 0.500 | 0.500 |" in text
    assert "| x | <u>0.200</u> | **1.000** |" in text  # errors: the lowest is best
    assert "| z | 0.100 | <u>2.000</u> |" in text
    assert "Footprint" not in text  # nobody has a figure
