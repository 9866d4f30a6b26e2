"""The scene is the map: walls where pixels are, bumps that meet the floor, the robot unchanged."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.world import load_world, write_nav2
from mobius.world.occupancy import OccupancyMap
from mobius.world.scene import SceneOptions, build_scene, wall_boxes
from mobius.world.terrain import bumps

ROBOT = """
<mujoco>
  <option timestep="0.002" jacobian="dense" iterations="7"/>
  <worldbody>
    <body name="trunk" pos="0 0 0.3">
      <freejoint/>
      <geom name="shell" type="box" size="0.2 0.15 0.08" mass="8"/>
    </body>
  </worldbody>
  <keyframe><key name="home" qpos="0 0 0.08 1 0 0 0"/></keyframe>
</mujoco>
"""


def robot():
    return mujoco.MjSpec.from_string(ROBOT)


@pytest.fixture(scope="module")
def demo():
    return load_world("demo", radius=0.37, margin=0.08)


@pytest.fixture(scope="module")
def model(demo):
    return build_scene(demo, robot()).compile()


def names(model, prefix):
    return [n for i in range(model.ngeom) if (n := model.geom(i).name).startswith(prefix)]


def height_at(model, xy):
    """Height [m] of what a ray straight down from 2 m hits first, and the geom's name."""
    data = mujoco.MjData(model)
    data.qpos[:3] = 0, 0, 50  # the robot out of the way
    mujoco.mj_forward(model, data)
    hit = np.zeros(1, dtype=np.int32)
    start, down = np.array([*xy, 2.0]), np.array([0.0, 0.0, -1.0])
    distance = mujoco.mj_ray(model, data, start, down, None, 1, -1, hit, None)
    return 2.0 - distance, model.geom(int(hit[0])).name


def covered(world, **options):
    """(h, w) how many wall boxes hold each pixel's centre."""
    centers = world.occupancy.pixel_centers()
    boxes = wall_boxes(world, options=SceneOptions(**options))
    return sum(box.contains(centers).astype(int) for box, _ in boxes)


def test_the_walls_of_a_clean_map_are_its_occupied_pixels(demo):
    # furniture stands 0.7 m deep; with a larger reach nothing is left out
    assert np.array_equal(covered(demo, near=2.0, fill=0.0), demo.occupancy.occupied)


def test_walls_hold_no_pixel_that_is_not_occupied_on_the_floor(demo):
    free = demo.occupancy.occupancy == 0
    assert not covered(demo)[free].any()


def test_walls_of_a_turned_map_stand_where_its_pixels_are(tmp_path):
    occupancy = np.full((40, 50), 100)
    occupancy[2:-2, 2:-2] = 0
    occupancy[10:13, 20:40] = 100
    raster = OccupancyMap("t", occupancy, 0.1, np.array([3.0, -1.0, 0.6]))
    write_nav2(tmp_path / "t.yaml", raster)
    world = load_world(tmp_path / "t.yaml", radius=0.3)
    assert np.array_equal(covered(world, near=2.0), world.occupancy.occupied)
    built = build_scene(world, robot()).compile()
    centers = world.occupancy.pixel_centers()
    for row, col in ((11, 30), (1, 25), (20, 48)):
        assert height_at(built, centers[row, col])[0] == pytest.approx(0.5)
    for row, col in ((9, 30), (13, 30), (20, 20)):
        assert height_at(built, centers[row, col]) == (pytest.approx(0.0), "floor")


def test_names_groups_and_masks_are_as_told(demo):
    options = SceneOptions(contype=2, conaffinity=4, wall_height=0.7)
    model = build_scene(demo, robot(), options=options).compile()
    ours = [g for g in range(model.ngeom) if model.geom(g).name != "shell"]
    assert all(model.geom(g).name for g in ours)
    assert (model.geom_group[ours] == 0).all()
    assert (model.geom_contype[ours] == 2).all()
    assert (model.geom_conaffinity[ours] == 4).all()
    assert len(names(model, "floor")) == len(names(model, "rough_")) == 1
    assert names(model, "shelf_") == ["shelf_0_board", *(f"shelf_0_leg_{i}" for i in range(4))]
    walls = [model.geom(n) for n in names(model, "wall_")]
    assert 0 < len(walls) < 30
    assert all(g.pos[2] == g.size[2] == 0.35 for g in walls)


def test_the_robot_keeps_its_options_and_its_keyframes(demo, model):
    alone = robot().compile()
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert not mujoco.mj_isSparse(model)
    assert (model.opt.timestep, model.opt.iterations) == (0.002, 7)
    assert (model.nq, model.nv, model.nkey) == (alone.nq, alone.nv, alone.nkey)
    assert np.array_equal(model.key("home").qpos, alone.key("home").qpos)


def test_the_robots_own_spec_is_left_alone(demo):
    spec = robot()
    build_scene(demo, spec)
    assert [g.name for g in spec.geoms] == ["shell"]


def test_a_spec_that_has_a_floor_is_refused(demo):
    spec = build_scene(demo, robot())
    with pytest.raises(InvalidInput, match="already has a 'floor'"):
        build_scene(demo, spec)


def test_the_rough_patch_rises_to_its_amplitude_and_meets_the_floor(demo, model):
    patch = demo.rough[0]
    want = bumps(patch)
    assert want.max() == pytest.approx(patch.amplitude)
    ny, nx = want.shape
    x, y = (np.linspace(-s / 2, s / 2, n) for s, n in zip(patch.area.size, (nx, ny), strict=True))
    for i in range(1, nx - 1, 3):
        for j in range(1, ny - 1, 3):
            got, name = height_at(model, patch.area.to_map([x[i], y[j]]))
            assert (got, name) == (pytest.approx(want[j, i], abs=1e-5), "rough_0")
    for edge in ([0.599, 0.3], [-0.599, 0.0], [0.1, 0.699], [0.0, -0.699]):
        assert height_at(model, patch.area.to_map(edge))[0] < 1e-4
    assert height_at(model, patch.area.to_map([0.65, 0.0])) == (pytest.approx(0.0), "floor")


def test_the_shelf_is_a_board_in_the_air(demo, model):
    shelf = demo.raised[0]
    assert height_at(model, shelf.area.center) == (pytest.approx(0.44), "shelf_0_board")
    data = mujoco.MjData(model)
    data.qpos[2] = 50
    mujoco.mj_forward(model, data)
    hit = np.zeros(1, dtype=np.int32)
    under, up = np.array([*shelf.area.center, 0.01]), np.array([0.0, 0.0, 1.0])
    assert mujoco.mj_ray(model, data, under, up, None, 1, -1, hit, None) == pytest.approx(0.39)


@pytest.mark.parametrize("spot", [(1.3, 1.2), (5.8, 2.2)])
def test_a_box_dropped_on_floor_or_bumps_comes_to_rest_on_them(model, spot):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.qpos[:3] = *spot, 0.15
    mujoco.mj_step(model, data, nstep=1000)
    assert np.abs(data.qvel).max() < 0.02
    assert np.linalg.norm(data.qpos[:2] - spot) < 0.05
    assert 0.079 < data.qpos[2] < 0.08 + 0.021


def test_a_wall_stops_a_box_that_is_pushed_into_it(demo, model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.qpos[:2] = 1.3, 2.2
    for _ in range(800):
        data.xfrc_applied[1, 0] = -120.0
        mujoco.mj_step(model, data)
    # the room begins at x = 0.4 and the box is 0.2 m long on either side
    assert data.qpos[0] == pytest.approx(0.6, abs=0.01)


def test_a_world_without_free_cells_still_becomes_a_scene(tmp_path):
    raster = OccupancyMap("t", np.full((10, 10), 100), 0.1, np.zeros(3))
    write_nav2(tmp_path / "t.yaml", raster)
    build_scene(load_world(tmp_path / "t.yaml", radius=0.3), robot()).compile()
