"""A scene as USD, looked at by OpenUSD's own parsers and validators and by closed forms, not by our reader."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdSemantics, UsdShade, UsdValidation

from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.pose import invert, level_camera, transform_points
from warehouse_sim.interchange import write_usd
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.scene import sample_scene
from warehouse_sim.scene.lighting.photometry import light_illuminance
from warehouse_sim.schema import IntensityDistribution, Light, Material
from warehouse_sim.schema.intensity import ANGLES, PLANES
from warehouse_sim.sensors.rig import RigConfig


@pytest.fixture(scope="module")
def recipe():
    return load_recipe("smoke")


@pytest.fixture(scope="module")
def scene(recipe):
    return sample_scene(recipe.scene, seed=0, scene_index=0)


@pytest.fixture(scope="module")
def stage(scene, recipe, tmp_path_factory):
    path = tmp_path_factory.mktemp("usd") / "scene.usdc"
    return Usd.Stage.Open(str(write_usd(scene, path, recipe.sensors)))


def box_scene(*, lights=(), **materials):
    """One carton whose material is called kraft, with further materials beside it."""
    kraft = Material("kraft", (0.44, 0.3, 0.175))
    model = box_model("carton", (0.6, 0.4, 0.3))
    named = {item.name: item for item in (kraft, *materials.values())}
    return make_scene([model], [("carton", at(0, 0, 0.15))], lights=lights, materials=named)


def opened(scene, path: Path, rig: RigConfig | None = None) -> Usd.Stage:
    return Usd.Stage.Open(str(write_usd(scene, path, rig)))


def validation_errors(stage: Usd.Stage) -> list[str]:
    registry = UsdValidation.ValidationRegistry()
    chosen = [
        item for item in registry.GetOrLoadAllValidators() if "UsdzValidators" not in item.GetMetadata().GetKeywords()
    ]
    assert len(chosen) > 20
    return [
        f"{error.GetName()}: {error.GetMessage()}" for error in UsdValidation.ValidationContext(chosen).Validate(stage)
    ]


def test_all_of_openusds_validators_pass(stage) -> None:
    assert validation_errors(stage) == []


def test_the_validators_would_tell_a_fault(scene, tmp_path: Path) -> None:
    stage = opened(scene, tmp_path / "scene.usda")
    stage.GetPrimAtPath("/World/Materials").GetChildren()[0].GetChild("albedo").GetAttribute("inputs:file").Set(
        Sdf.AssetPath("./textures/nowhere.png")
    )
    assert any("nowhere.png" in item for item in validation_errors(stage))


def test_triangles_and_bounds_are_those_of_the_scene(scene, stage) -> None:
    """Walk the composed stage with OpenUSD's own transforms, as a renderer does."""
    cache, bounds = UsdGeom.XformCache(), UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    world = {item.instance_id: transform_points(item.T_world_object, scene.model_of(item).mesh().vertices)
             for item in scene.instances}  # fmt: skip
    seen = dict.fromkeys(world, 0)
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if not prim.IsA(UsdGeom.Mesh):
            continue
        owner = prim.GetParent().GetParent()
        number = owner.GetCustomDataByKey("instance_id")
        mesh = UsdGeom.Mesh(prim)
        seen[number] += len(mesh.GetFaceVertexCountsAttr().Get())
        matrix = np.array(cache.GetLocalToWorldTransform(prim))
        points = np.array(mesh.GetPointsAttr().Get(), float) @ matrix[:3, :3] + matrix[3, :3]
        assert (points >= world[number].min(axis=0) - 1e-6).all()
        assert (points <= world[number].max(axis=0) + 1e-6).all()
    assert seen == {item.instance_id: len(scene.model_of(item).mesh().faces) for item in scene.instances}
    box = bounds.ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
    every = np.concatenate([*world.values()])
    lamps = np.concatenate([[item.position - 0.2, item.position + 0.2] for item in scene.lights])
    assert (np.array(box.GetMin()) <= every.min(axis=0) + 1e-5).all()
    assert np.array(box.GetMax()) == pytest.approx(np.maximum(every, lamps.max(axis=0)).max(axis=0), abs=0.5)


def test_objects_are_instances_that_stand_alone(scene, stage) -> None:
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert [prim.GetName() for prim in stage.GetPseudoRoot().GetChildren()] == ["World"]
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == UsdPhysics.GetStageKilogramsPerUnit(stage) == 1.0
    objects = [prim for prim in stage.GetDefaultPrim().GetChildren() if prim.GetCustomDataByKey("instance_id")]
    assert len(objects) == len(scene.instances)
    assert all(prim.IsInstance() and Usd.ModelAPI(prim).GetKind() == "component" for prim in objects)
    assert Usd.ModelAPI(stage.GetDefaultPrim()).GetKind() == "assembly"
    assert len(stage.GetPrototypes()) == len({item.look for item in scene.instances})


def test_another_stage_can_refer_to_the_scene(scene, stage, tmp_path: Path) -> None:
    """All that objects refer to lies under the default prim, and travels with it."""
    other = Usd.Stage.CreateNew(str(tmp_path / "other.usda"))
    other.OverridePrim("/Hall").GetReferences().AddReference(stage.GetRootLayer().identifier)
    prim = other.GetPrimAtPath("/Hall/object_000018")
    meshes = prim.GetPrototype().GetChild("Geometry").GetChildren()
    assert meshes
    assert all(UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0] for mesh in meshes)


def test_every_object_has_its_class_as_a_label(scene, stage) -> None:
    query = UsdSemantics.LabelsQuery("class", Usd.TimeCode.Default())
    for item in scene.instances:
        prim = stage.GetPrimAtPath(f"/World/object_{item.instance_id:06d}")
        assert list(query.ComputeUniqueDirectLabels(prim)) == [scene.model_of(item).class_name]
        inside = prim.GetPrototype().GetChild("Geometry").GetChildren()[0].GetPath().name
        proxy = stage.GetPrimAtPath(f"{prim.GetPath()}/Geometry/{inside}")
        assert scene.model_of(item).class_name in list(query.ComputeUniqueInheritedLabels(proxy))


@pytest.mark.filterwarnings("ignore:LoadUsdPhysicsFromRange")  # its successor is not in older versions
def test_openusds_physics_parser_finds_bodies_and_boxes(scene, stage) -> None:
    found = UsdPhysics.LoadUsdPhysicsFromRange(stage, ["/"])
    bodies, _ = found[UsdPhysics.ObjectType.RigidBody]
    loose = {f"/World/object_{item.instance_id:06d}": item for item in scene.instances if item.dynamic}
    assert {str(path) for path in bodies} == set(loose)
    for path, item in loose.items():
        mass = UsdPhysics.MassAPI(stage.GetPrimAtPath(path)).GetMassAttr().Get()
        assert mass == pytest.approx(scene.model_of(item).mass, rel=1e-6)
    boxes: dict[int, list[tuple[np.ndarray, np.ndarray, str]]] = {}
    for path, shape in zip(*found[UsdPhysics.ObjectType.CubeShape], strict=True):
        number = int(str(path).split("/")[2].removeprefix("object_"))
        assert [str(item) for item in shape.materials] == ["/World/friction"]
        boxes.setdefault(number, []).append((2 * np.array(shape.halfExtents), shape.localPos, str(shape.rigidBody)))
    for item in scene.instances:
        expected, got = scene.model_of(item).collision, boxes.get(item.instance_id, [])
        assert len(got) == len(expected)
        for (size, position, body), box in zip(got, expected, strict=True):
            np.testing.assert_allclose(size, box.size, atol=1e-5)
            if item.dynamic:
                assert body == f"/World/object_{item.instance_id:06d}"
                np.testing.assert_allclose(position, box.T_parent_box[:3, 3], atol=1e-6)
    (physics,) = found[UsdPhysics.ObjectType.Scene][1]
    assert physics.gravityMagnitude == pytest.approx(9.81)
    (material,) = found[UsdPhysics.ObjectType.RigidBodyMaterial][1]
    assert (material.staticFriction, material.dynamicFriction) == (0.5, 0.5)


@pytest.mark.parametrize(
    "camera", [{"width": 640, "height": 480, "focal_px": 500.0, "cx": 300.0, "cy": 260.0}, "kitti"]
)
def test_cameras_show_points_where_ours_do(camera, tmp_path: Path) -> None:
    """``Gf.Frustum`` projects as renderers of USD do."""
    rig = RigConfig.from_plain({"rig": "dissertation", "camera": camera}, "rig")
    scene = make_scene([box_model("carton", (0.6, 0.4, 0.3))], [("carton", at(0, 0, 0))],
                       viewpoints=[level_camera(np.array([1.0, 2.0, 3.0]), 0.4, -0.2)])  # fmt: skip
    stage = opened(scene, tmp_path / "scene.usda", rig)
    shown = UsdGeom.Camera(stage.GetPrimAtPath("/World/Viewpoints/viewpoint_000/camera"))
    frustum = shown.GetCamera().frustum
    to_clip = np.array(frustum.ComputeViewMatrix()) @ np.array(frustum.ComputeProjectionMatrix())
    pinhole, T_world_camera = rig.make_camera(), scene.viewpoints[0].T_world_camera
    points = np.random.default_rng(0).uniform([-2, -1, 2], [2, 1, 9], (50, 3))
    clip = np.column_stack([transform_points(T_world_camera, points), np.ones(50)]) @ to_clip
    x, y = (clip[:, :2] / clip[:, 3:]).T
    # Normalised coordinates run from edge to edge, ours count from the centre of the first pixel.
    u, v = (x + 1) / 2 * pinhole.width - 0.5, (1 - y) / 2 * pinhole.height - 0.5
    np.testing.assert_allclose(np.stack([u, v], axis=1), pinhole.project(points), atol=2e-3)
    assert shown.ComputeLinearExposureScale() == pytest.approx(scene.exposure, rel=1e-5)


def test_sensors_stand_where_the_rig_mounts_them(scene, stage, recipe) -> None:
    cache = UsdGeom.XformCache()
    for number, viewpoint in enumerate(scene.viewpoints):
        for name, mounted in recipe.sensors.mounted().items():
            prim = stage.GetPrimAtPath(f"/World/Viewpoints/viewpoint_{number:03d}/{name}")
            found = np.array(cache.GetLocalToWorldTransform(prim)).T
            expected = viewpoint.T_world_camera @ mounted.T_camera_sensor(viewpoint)
            np.testing.assert_allclose(found[:3, 3], expected[:3, 3], atol=1e-9)
            np.testing.assert_allclose(found[:3, 0], expected[:3, 0], atol=1e-9)
            assert prim.IsA(UsdGeom.Camera) == (name in ("camera", "right"))


def test_a_lens_is_told_to_omniverse(tmp_path: Path) -> None:
    rig = RigConfig.from_plain({"rig": "dissertation", "camera": "wide"}, "rig")
    stage = opened(replace(box_scene(), viewpoints=make_scene([], [], viewpoints=[np.eye(4)]).viewpoints),
                   tmp_path / "scene.usda", rig)  # fmt: skip
    prim = stage.GetPrimAtPath("/World/Viewpoints/viewpoint_000/camera")
    assert "OmniLensDistortionOpenCvPinholeAPI" in prim.GetMetadata("apiSchemas").GetAppliedItems()
    assert prim.GetAttribute("omni:lensdistortion:opencvPinhole:k1").Get() == pytest.approx(-0.31)
    assert prim.GetAttribute("omni:lensdistortion:opencvPinhole:cx").Get() == pytest.approx(640.0)
    assert validation_errors(stage) == []


def luminous_distribution() -> IntensityDistribution:
    """Bright along the half plane 0 and to one side, so that a turn or a mirror image would show."""
    plane, angle = np.arange(PLANES) * (2 * np.pi / PLANES), np.radians(np.linspace(0, 180, ANGLES))
    fraction = (1.2 + np.cos(plane) + 0.5 * np.sin(plane))[:, None] * np.maximum(np.cos(angle), 0.0)[None] ** 2
    return IntensityDistribution("skew", 900.0, (fraction / fraction.max()).astype(np.float32))


LIGHTS = {
    "spot": Light("spot", np.array([1.0, 2.0, 6.0]), np.array([0.6, 0.0, -0.8]), 4000.0, (1.1, 1.0, 0.8), 0.4, 1.0),
    "point": Light("point", np.array([0.0, 1.0, 3.0]), np.array([0.0, 0.0, -1.0]), 250.0, radius=0.0),
    "file": Light("spot", np.array([0.0, 0.0, 5.0]), np.array([0.0, 0.6, -0.8]), 3000.0,
                  distribution=luminous_distribution(), along=(1.0, 0.0, 0.0)),
}  # fmt: skip


def shaped(prim: Usd.Prim, away: np.ndarray) -> np.ndarray:
    """Return the fraction of a light's luminance in directions of its own frame, from its IES file or its cone."""
    if not prim.HasAPI(UsdLux.ShapingAPI):
        return np.ones(len(away))
    shaping = UsdLux.ShapingAPI(prim)
    asset = shaping.GetShapingIesFileAttr().Get()
    angle = np.degrees(np.arccos(-away[:, 2]))
    if asset is None:
        cutoff = shaping.GetShapingConeAngleAttr().Get()
        start = cutoff * (1 - shaping.GetShapingConeSoftnessAttr().Get())
        t = np.clip((angle - start) / (cutoff - start), 0, 1)
        return 1 - t * t * (3 - 2 * t)
    text = Path(asset.resolvedPath).read_text().split("TILT=NONE")[1].split()
    counts, numbers = [int(item) for item in text[3:5]], np.array(text[13:], float)
    vertical, horizontal = numbers[: counts[0]], numbers[counts[0] : sum(counts)]
    candela = numbers[sum(counts) :].reshape(counts[1], counts[0])
    turned = np.degrees(np.arctan2(away[:, 1], away[:, 0])) % 360
    column = [np.array([np.interp(a, vertical, row) for row in candela]) for a in angle]
    return np.array([np.interp(p, horizontal, values) for p, values in zip(turned, column, strict=True)])


@pytest.mark.parametrize("name", LIGHTS)
def test_lights_give_the_same_lux(name: str, tmp_path: Path) -> None:
    """A ball of luminance L gives L pi r^2 / d^2 (inverse square law), by what its shaping lets through."""
    light = LIGHTS[name]
    stage = opened(box_scene(lights=[light]), tmp_path / "scene.usda")
    prim = stage.GetPrimAtPath("/World/Lights/light_000")
    ball, T_world_light = UsdLux.SphereLight(prim), np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim)).T
    rng = np.random.default_rng(1)
    away = rng.normal(size=(400, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    points = light.position + away * rng.uniform(2, 6, (400, 1))
    local = transform_points(invert(T_world_light), points)
    distance = np.linalg.norm(local, axis=1)
    candela = ball.GetIntensityAttr().Get() * np.pi * ball.GetRadiusAttr().Get() ** 2
    got = candela * shaped(prim, local / distance[:, None]) / distance**2
    expected = light_illuminance(light, points, -away)
    if name == "spot":  # the two fall off differently between the angles of the cone, and agree within and beyond
        off = np.arccos(np.clip(away @ light.direction, -1, 1))
        got, expected = (item[(off < 0.39) | (off > 1.01)] for item in (got, expected))
        assert (expected > 0).sum() > 5
    np.testing.assert_allclose(got, expected, rtol=2e-4, atol=2e-4 * expected.max())
    assert prim.GetCustomDataByKey("lumen") > 0
    assert tuple(ball.GetColorAttr().Get()) == pytest.approx(light.color)


def test_even_light_gives_its_lux(stage, scene) -> None:
    dome = UsdLux.DomeLight(stage.GetPrimAtPath("/World/Lights/even_light"))
    assert dome.GetIntensityAttr().Get() * np.pi == pytest.approx(scene.ambient, rel=1e-6)


def surface_of(stage: Usd.Stage, name: str) -> UsdShade.Shader:
    return UsdShade.Shader(stage.GetPrimAtPath(f"/World/Materials/{name}/surface"))


def sampled(stage: Usd.Stage, surface: UsdShade.Shader, name: str, st: np.ndarray) -> np.ndarray:
    """Return what a surface's input is at texture coordinates: the nearest texel, scale and bias (UsdUVTexture)."""
    source, _, _ = surface.GetInput(name).GetConnectedSource()
    image = UsdShade.Shader(source.GetPrim())
    file = Path(image.GetInput("file").Get().resolvedPath)
    assert file.parent == Path(stage.GetRootLayer().realPath).parent / "textures"
    texels = cv2.imread(str(file), cv2.IMREAD_COLOR)[..., ::-1] / 255.0
    if image.GetInput("sourceColorSpace").Get() == "sRGB":
        texels = np.where(texels > 0.04045, ((texels + 0.055) / 1.055) ** 2.4, texels / 12.92)
    height, width = texels.shape[:2]
    row, column = ((1 - st[:, 1]) % 1 * height).astype(int), (st[:, 0] % 1 * width).astype(int)
    found = texels[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
    for key, join in (("scale", np.multiply), ("bias", np.add)):
        if image.GetInput(key):
            found = join(found, np.array(image.GetInput(key).Get())[:3])
    return found


def test_textures_have_the_colour_of_their_material(tmp_path: Path) -> None:
    """A detail texture has the mean 1, so the mean over the surface is the base colour."""
    base = (0.42, 0.29, 0.165)
    wood = Material("kraft", base, roughness=0.6, texture="wood", texture_size=0.5)
    stage = opened(box_scene(kraft=wood), tmp_path / "scene.usda")
    st = np.random.default_rng(0).uniform(0, 1, (20_000, 2))
    surface = surface_of(stage, "kraft")
    assert sampled(stage, surface, "diffuseColor", st).mean(axis=0) == pytest.approx(base, rel=0.05)
    assert sampled(stage, surface, "roughness", st)[:, 0].mean() == pytest.approx(0.6, rel=0.1)
    normal = sampled(stage, surface, "normal", st).mean(axis=0)
    assert normal == pytest.approx([0, 0, 1], abs=0.06)


def test_a_label_lies_upright_and_is_read_from_the_left(tmp_path: Path) -> None:
    """The picture's corners are at the front face's corners: its top towards +z, its left at the beholder's left."""
    label = Material("kraft", (0.44, 0.3, 0.175), picture="shipping_label:4711")
    scene = box_scene(kraft=label)
    scene = replace(scene, models={"carton": box_model("carton", (0.2, 0.001, 0.1))})
    stage = opened(scene, tmp_path / "scene.usda")
    proxy = stage.GetPrimAtPath("/World/object_000001/Geometry/part_000")
    st = np.array(UsdGeom.PrimvarsAPI(proxy).GetPrimvar("st").ComputeFlattened()).reshape(-1, 3, 2)
    mesh = UsdGeom.Mesh(proxy)
    points = np.array(mesh.GetPointsAttr().Get())[np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)]
    normals = np.array(mesh.GetNormalsAttr().Get()).reshape(-1, 3, 3)[:, 0]
    front, back = normals[:, 1] < -0.5, normals[:, 1] > 0.5
    np.testing.assert_allclose(st[front, :, 0], points[front, :, 0] + 0.5, atol=1e-6)
    np.testing.assert_allclose(st[back, :, 0], 0.5 - points[back, :, 0], atol=1e-6)
    np.testing.assert_allclose(st[front | back, :, 1], points[front | back, :, 2] + 0.5, atol=1e-6)
    image = UsdShade.Shader(stage.GetPrimAtPath("/World/Materials/kraft/picture"))
    assert image.GetInput("sourceColorSpace").Get() == "sRGB"
    assert image.GetInput("file").Get().path.startswith("./textures/shipping_label_")


def test_film_lamps_and_plain_materials(tmp_path: Path) -> None:
    film = Material("film", (0.9, 0.9, 0.9), opacity=0.15)
    lamp = Material("lamp", (1.0, 0.9, 0.8), emission=5000.0)
    stage = opened(box_scene(film=film, lamp=lamp), tmp_path / "scene.usda")
    assert surface_of(stage, "film").GetInput("opacity").Get() == pytest.approx(0.15)
    assert surface_of(stage, "lamp").GetInput("emissiveColor").Get() == Gf.Vec3f(5000.0, 4500.0, 4000.0)
    assert not surface_of(stage, "kraft").GetInput("diffuseColor").HasConnectedSource()


def test_names_that_usd_cannot_tell_apart_stay_apart(tmp_path: Path) -> None:
    scene = box_scene(one=Material("red board", (1, 0, 0)), other=Material("red_board", (0, 0, 1)))
    stage = opened(scene, tmp_path / "scene.usda")
    shown = [surface_of(stage, name).GetInput("diffuseColor").Get() for name in ("red_board", "red_board_2")]
    assert shown == [Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 0, 1)]


def test_the_same_scene_gives_the_same_bytes(scene, recipe, tmp_path: Path) -> None:
    for folder in ("one", "two"):
        for name in ("scene.usda", "scene.usdc"):
            write_usd(scene, tmp_path / folder / name, recipe.sensors)
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*") if path.is_file())
    assert [str(path.parent) for path in files].count("textures") >= 15
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()
    assert not any(path.name.startswith(".") for path in (tmp_path / "one").rglob("*"))
