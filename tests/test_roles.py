"""Names of maps, as libraries and programs give them."""

import pytest

from weftex.roles import ROLES, Role, is_name_of, is_preview, role_of

#: Stems of files from ambientCG, Poly Haven, Substance, Megascans, Materialize, Unity and glTF.
STEMS = {
    "color": ["Bricks075A_1K-PNG_Color", "brick_wall_02_diff_4k", "brick_wall_BaseColor",
              "brick_baseColor", "tlrkcbjn_4K_Albedo", "color_16bit", "diffuse_old_wall"],
    "normal_gl": ["Bricks075A_1K-PNG_NormalGL", "brick_wall_02_nor_gl_4k"],
    "normal_dx": ["Bricks075A_1K-PNG_NormalDX", "brick_wall_02_nor_dx_4k"],
    "height": ["Bricks075A_1K-PNG_Displacement", "brick_wall_02_disp_4k", "height.png"],
    "roughness": ["Bricks075A_1K-PNG_Roughness", "brick_wall_02_rough_4k", "roughness-2k"],
    "ao": ["Bricks075A_1K-PNG_AmbientOcclusion", "brick_wall_Ambient_Occlusion", "AO"],
    "orm": ["brick_wall_02_arm_4k", "brick_wall_OcclusionRoughnessMetallic"],
    "normal": ["tlrkcbjn_4K_Normal_LOD0", "brick_NormalMap", "normal map"],
    "mask_map": ["brick_MaskMap", "brick_MaskMap_4k"],
    "metallic_smoothness": ["brick_MetallicSmoothness"],
    "metallic_roughness": ["brick_metallicRoughness"],
    None: ["bricks", "leaves", "IMG_2041", "DSC00012", "wood", "colorful", "", "4k", "normandy"],
}  # fmt: skip


@pytest.mark.parametrize("role", STEMS)
def test_names_are_known(role):
    assert {role_of(stem) for stem in STEMS[role]} == {ROLES.get(role)}


def test_every_name_of_the_table_is_its_role():
    for role in ROLES.values():
        for words in (role.name.replace("_", " "), *role.files):
            for stem in (words, words.replace(" ", "_"), f"brick_{words}_4k", words.upper()):
                assert role_of(stem) is role, stem
        for part in role.channels:
            assert part in {*ROLES, "unused", "detail"}


def test_what_roles_are():
    assert {name for name, role in ROLES.items() if role.srgb} == {
        "color", "emission", "specular_color", "translucency"
    }  # fmt: skip
    assert {role.kind for role in ROLES.values()} == {"color", "normal", "height", "labels", "data"}
    assert str(Role("wetness")) == "wetness"


def test_previews():
    maps = ["Rock01_1K_Color", "Rock01_1K_NormalGL"]
    for stem in ("Rock01_PREVIEW", "preview", "tlrkcbjn_thumb", "Rock01_Color_Thumb"):
        assert is_preview(stem) and not is_preview(f"{stem}s2"), stem
    assert is_name_of("Rock01", maps) and is_name_of("Rock01_1K", maps)
    for stem in ("Rock02", "Rock01_Color", "Rock01_more", "", "4k"):
        assert not is_preview(stem) and not is_name_of(stem, maps), stem
    assert not is_name_of("Rock01", [])
