"""Names of maps, as libraries and programs give them."""

from __future__ import annotations

import pytest

from weftex.errors import InvalidInputError
from weftex.io.map_names import ROLES, role_of, roles_of

SETS = {
    "ambientCG": {
        "Bricks075A_1K-PNG_Color": "color",
        "Bricks075A_1K-PNG_NormalGL": "normal (OpenGL)",
        "Bricks075A_1K-PNG_NormalDX": "normal (DirectX)",
        "Bricks075A_1K-PNG_Displacement": "height",
        "Bricks075A_1K-PNG_Roughness": "roughness",
        "Bricks075A_1K-PNG_AmbientOcclusion": "ambient occlusion",
        "Bricks075A_1K-PNG_Metalness": "metalness",
    },
    "Poly Haven": {
        "brick_wall_02_diff_4k": "color",
        "brick_wall_02_nor_gl_4k": "normal (OpenGL)",
        "brick_wall_02_nor_dx_4k": "normal (DirectX)",
        "brick_wall_02_disp_4k": "height",
        "brick_wall_02_rough_4k": "roughness",
        "brick_wall_02_ao_4k": "ambient occlusion",
        "brick_wall_02_arm_4k": "occlusion, roughness, metalness",
        "brick_wall_02_spec_4k": "specular",
    },
    "Substance": {
        "brick_wall_BaseColor": "color",
        "brick_wall_Base_Color": "color",
        "brick_wall_Normal": "normal",
        "brick_wall_Height": "height",
        "brick_wall_Metallic": "metalness",
        "brick_wall_Ambient_Occlusion": "ambient occlusion",
        "brick_wall_Opacity": "opacity",
        "brick_wall_Emissive": "emission",
        "brick_wall_Glossiness": "gloss",
        "brick_wall_OcclusionRoughnessMetallic": "occlusion, roughness, metalness",
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
    "glTF": {
        "brick_baseColor": "color",
        "brick_metallicRoughness": "metalness and roughness",
        "brick_occlusion": "ambient occlusion",
        "brick_normal": "normal",
    },
    "plain": {
        "albedo": "color",
        "color_16bit": "color",
        "normal map": "normal",
        "roughness-2k": "roughness",
        "AO": "ambient occlusion",
        "height.png": "height",
        "diffuse_old_wall": "color",
    },
    "photos": dict.fromkeys(
        ("bricks", "leaves", "IMG_2041", "DSC00012", "wood", "colorful", "", "4k", "normandy")
    ),
}


@pytest.mark.parametrize("which", SETS)
def test_names_are_known(which):
    assert {stem: role_of(stem) for stem in SETS[which]} == SETS[which]


def test_every_name_of_the_table_is_its_role():
    for role, names in ROLES.items():
        for words in names:
            for stem in (words, words.replace(" ", "_"), f"brick_{words}_4k", words.upper()):
                assert role_of(stem) == role, stem


def test_unrelated_pictures_are_refused():
    with pytest.raises(InvalidInputError, match=r"of no map \(bricks, leaves\).*--maps color=FILE"):
        roles_of(["albedo", "bricks", "leaves"], "photos")
    with pytest.raises(InvalidInputError, match="two pictures that are named color .a_col, b_col"):
        roles_of(["a_col", "b_col"], "photos")
    assert roles_of(["height", "normal"], "maps") == {"height": "height", "normal": "normal"}
