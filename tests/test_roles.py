"""Names of maps, as libraries and programs give them."""

from __future__ import annotations

import pytest

from weftex.roles import ROLES, Role, is_name_of, is_preview, role_of

SETS = {
    "ambientCG": {
        "Bricks075A_1K-PNG_Color": "color",
        "Bricks075A_1K-PNG_NormalGL": "normal_gl",
        "Bricks075A_1K-PNG_NormalDX": "normal_dx",
        "Bricks075A_1K-PNG_Displacement": "height",
        "Bricks075A_1K-PNG_Roughness": "roughness",
        "Bricks075A_1K-PNG_AmbientOcclusion": "ao",
        "Bricks075A_1K-PNG_Metalness": "metallic",
    },
    "Poly Haven": {
        "brick_wall_02_diff_4k": "color",
        "brick_wall_02_nor_gl_4k": "normal_gl",
        "brick_wall_02_nor_dx_4k": "normal_dx",
        "brick_wall_02_disp_4k": "height",
        "brick_wall_02_rough_4k": "roughness",
        "brick_wall_02_ao_4k": "ao",
        "brick_wall_02_arm_4k": "orm",
        "brick_wall_02_spec_4k": "specular",
    },
    "Substance": {
        "brick_wall_BaseColor": "color",
        "brick_wall_Base_Color": "color",
        "brick_wall_Normal": "normal",
        "brick_wall_Height": "height",
        "brick_wall_Metallic": "metallic",
        "brick_wall_Ambient_Occlusion": "ao",
        "brick_wall_Opacity": "opacity",
        "brick_wall_Emissive": "emission",
        "brick_wall_Glossiness": "gloss",
        "brick_wall_OcclusionRoughnessMetallic": "orm",
    },
    "Megascans": {
        "tlrkcbjn_4K_Albedo": "color",
        "tlrkcbjn_4K_Normal_LOD0": "normal",
        "tlrkcbjn_4K_Displacement": "height",
        "tlrkcbjn_4K_Cavity": "cavity",
        "tlrkcbjn_4K_Fuzz": "fuzz",
        "tlrkcbjn_4K_Gloss": "gloss",
        "tlrkcbjn_4K_Translucency": "translucency",
    },
    "Materialize": {
        "brick_diffuse": "color",
        "brick_height": "height",
        "brick_normal": "normal",
        "brick_metallic": "metallic",
        "brick_smoothness": "gloss",
        "brick_edge": "edge",
        "brick_ao": "ao",
    },
    "Unity": {
        "brick_MaskMap": "mask_map",
        "brick_MaskMap_4k": "mask_map",
        "brick_MetallicSmoothness": "metallic_smoothness",
        "brick_NormalMap": "normal",
    },
    "glTF": {
        "brick_baseColor": "color",
        "brick_metallicRoughness": "metallic_roughness",
        "brick_occlusion": "ao",
        "brick_normal": "normal",
    },
    "plain": {
        "albedo": "color",
        "color_16bit": "color",
        "normal map": "normal",
        "roughness-2k": "roughness",
        "AO": "ao",
        "height.png": "height",
        "diffuse_old_wall": "color",
    },
    "photos": dict.fromkeys(
        ("bricks", "leaves", "IMG_2041", "DSC00012", "wood", "colorful", "", "4k", "normandy")
    ),
}


def name_of(stem):
    role = role_of(stem)
    return role and role.name


@pytest.mark.parametrize("which", SETS)
def test_names_are_known(which):
    assert {stem: name_of(stem) for stem in SETS[which]} == SETS[which]


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
