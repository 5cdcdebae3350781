/** One triangle that covers the view. */
export const VERTEX = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

/** The material's maps, and what is read of them. Where a map is missing, brightness stands for the heights. */
const MATERIAL = `#version 300 es
precision highp float;
uniform sampler2D colorMap, normalMap, roughnessMap, heightMap, occlusionMap, metallicMap;
uniform bool has_normal, has_roughness, has_height, has_occlusion, has_metallic, has_color;
uniform vec2 size;
uniform float relief, down, openness, roughness;

float heightAt(vec2 uv, float level) {
  if (has_height) return textureLod(heightMap, uv, level).r;
  return dot(textureLod(colorMap, uv, level).rgb, vec3(0.25, 0.6, 0.15));
}
`;

const SURFACE = `
out vec4 shown;
const float PI = 3.14159265;

/** In pixels of the picture: x to the right, y down, z out of it. */
vec3 normalAt(vec2 uv) {
  if (has_normal) {
    vec3 n = texture(normalMap, uv).rgb * 2.0 - 1.0;
    n.y *= down;
    return normalize(vec3(n.xy * relief, max(n.z, 0.05)));
  }
  vec2 dx = vec2(1.0 / size.x, 0.0), dy = vec2(0.0, 1.0 / size.y);
  float strength = (has_height ? 6.0 : 1.6) * relief;
  float sx = heightAt(uv + dx, 0.0) - heightAt(uv - dx, 0.0);
  float sy = heightAt(uv + dy, 0.0) - heightAt(uv - dy, 0.0);
  return normalize(vec3(-sx * strength, -sy * strength, 1.0));
}

/** How open to the sky a place is: by its map, or by how deep it lies below what is around it. */
float openAt(vec2 uv) {
  float open = has_occlusion ? texture(occlusionMap, uv).r : 1.0 - 2.0 * max(heightAt(uv, 4.5) - heightAt(uv, 0.0), 0.0);
  return clamp(mix(1.0, open, openness), 0.0, 1.0);
}

/** Heights throw shadows: a few steps towards the light. */
float lit(vec2 uv, vec3 towards) {
  if (!has_height) return 1.0;
  vec2 way = towards.xy / max(towards.z, 0.2) * 18.0 / size * relief;
  float start = heightAt(uv, 0.0), shade = 0.0;
  for (int k = 1; k <= 10; k++) {
    float share = float(k) / 10.0;
    shade = max(shade, heightAt(uv + way * share, 0.0) - start - share * 0.9);
  }
  return 1.0 - 0.85 * smoothstep(0.0, 0.12, shade);
}

/** A microfacet surface (GGX, Smith's masking, Schlick's Fresnel term) under one light and an even sky. */
vec4 surface(vec2 uv, vec3 n, vec3 l, vec3 v, float power, float up) {
  vec4 base = texture(colorMap, uv);
  float rough = clamp((has_roughness ? texture(roughnessMap, uv).r : 0.65) * roughness, 0.06, 1.0);
  float metal = has_metallic ? texture(metallicMap, uv).r : 0.0;
  float open = openAt(uv);
  vec3 m = normalize(l + v);
  float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 0.02), nm = max(dot(n, m), 0.0);
  float a = rough * rough, a2 = a * a;
  float spread = nm * nm * (a2 - 1.0) + 1.0;
  float facets = a2 / (PI * spread * spread);
  float masked = 0.5 / max(mix(2.0 * nl * nv, nl + nv, a), 1e-4);
  vec3 f0 = mix(vec3(0.04), base.rgb, metal);
  vec3 mirrored = f0 + (1.0 - f0) * pow(1.0 - max(dot(v, m), 0.0), 5.0);
  vec3 matte = base.rgb * (1.0 - metal) / PI;
  vec3 sky = (base.rgb * (1.0 - metal) + f0 * 0.6) * mix(0.16, 0.3, up * 0.5 + 0.5) * open;
  vec3 sum = sky * 0.7 + (matte * (1.0 - mirrored) + min(facets * masked, 24.0) * mirrored) * nl * power * mix(1.0, open, 0.5);
  sum = sum / (1.0 + max(sum - 0.8, 0.0) * 0.6);
  vec3 curve = mix(sum * 12.92, 1.055 * pow(max(sum, 1e-4), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, sum));
  return vec4(clamp(curve, 0.0, 1.0), 1.0);
}
`;

/** The picture flat on the screen, under a near light. */
export const FRAGMENT = `${MATERIAL}
uniform vec2 screen, middle;
uniform vec3 light;
uniform float scale, repeat;
${SURFACE}
void main() {
  vec2 pixel = vec2(gl_FragCoord.x, screen.y - gl_FragCoord.y);
  vec2 place = middle + (pixel - 0.5 * screen) / scale;
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, size * repeat))) {
    shown = vec4(0.0);
    return;
  }
  vec2 uv = place / size;
  vec3 n = normalAt(uv);
  vec2 here = 2.0 * pixel / screen - 1.0;
  vec3 way = vec3((light.xy - here) * vec2(screen.x / screen.y, 1.0), light.z);
  vec3 l = normalize(way);
  float power = 2.2 * PI / (0.55 + dot(way, way)) * lit(uv, l);
  shown = surface(uv, n, l, vec3(0.0, 0.0, 1.0), power, n.z);
}`;

/** A solid: its points move along their normals by the height. `fade` is 0 at edges, so that none opens. */
export const SOLID_VERTEX = `${MATERIAL}
in vec3 place, normal, tangent;
in vec3 texture_place; // its third part is the fade
uniform mat4 view;
uniform vec2 times;
uniform float displacement;
out vec3 at, out_normal, out_tangent;
out vec2 uv;
void main() {
  uv = texture_place.xy * times;
  at = place + normal * (heightAt(uv, 1.0) - 0.5) * displacement * texture_place.z;
  out_normal = normal;
  out_tangent = tangent;
  gl_Position = view * vec4(at, 1.0);
}`;

export const SOLID_FRAGMENT = `${MATERIAL}
in vec3 at, out_normal, out_tangent;
in vec2 uv;
uniform vec3 eye, sun;
${SURFACE}
void main() {
  vec3 n = normalize(out_normal), right = normalize(out_tangent), below = cross(right, n);
  vec3 fine = normalAt(uv);
  vec3 l = normalize(sun), v = normalize(eye - at);
  vec3 towards = vec3(dot(l, right), dot(l, below), dot(l, n));
  vec3 bent = normalize(right * fine.x + below * fine.y + n * fine.z);
  float facing = smoothstep(-0.1, 0.15, dot(n, l));
  shown = surface(uv, bent, l, v, PI * 1.15 * facing * (facing > 0.0 ? lit(uv, towards) : 0.0), bent.y);
}`;
