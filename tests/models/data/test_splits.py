"""What is held out, and that nothing of one place is on both sides."""

import pytest

from footprints_edge_models.data.splits import halves_cut, held_out, scenes_cut


class Item:
    def __init__(self, name):
        self.name = name


def pictures(count, views, missing=()):
    numbers = [number for number in range(count) if number not in missing]
    return [f"synthetic_scenes/{number:06d}" for number in numbers], views


@pytest.mark.parametrize(
    ("names", "views"),
    [
        pictures(6000, 4),
        pictures(6001, 4),
        pictures(5998, 3),
        pictures(130, 4),
        pictures(150, 4),
        pictures(60, 1),
        pictures(400, 4, missing={390, 391, 395, 399}),
        pictures(400, 4, missing={391, 392, 393}),
    ],
)
def test_no_scene_is_on_both_sides_of_the_cut(names, views):
    end, begin = scenes_cut(names, views)
    trained, held = ({int(n[-6:]) // views for n in part} for part in (names[:end], names[begin:]))
    assert trained
    assert held
    assert not trained & held
    wanted = min(100, len(names) // 50)
    assert wanted - views < len(names) - begin <= max(wanted, views)
    if len(names) - begin <= wanted:  # then what is trained on is as if each were a scene
        assert end == len(names) - wanted
    items = [Item(name) for name in names]
    assert held_out("synthetic_scenes", items, views) == items[begin:]


def test_few_scenes_are_all_trained_on():
    assert scenes_cut([f"a/{k}" for k in range(49)], 4) == (49, 49)


@pytest.mark.parametrize(
    ("names", "views", "cut"),
    [
        ([f"scenes/{k:06d}" for k in range(10)], 4, 4),
        ([f"clip/{k:05d}" for k in range(9)], 1, 4),
        ([f"panoramas/{name}_{k}" for name in "abc" for k in range(3)], 1, 3),
        (["houses/a_hall", "houses/a_bath"], 1, 2),
        ([], 1, 0),
    ],
)
def test_halves_have_no_place_in_common(names, views, cut):
    assert halves_cut(names, views) == cut
