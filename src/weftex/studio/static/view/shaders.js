/** One triangle that covers the view. */
export const VERTEX = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

/**
 * A microfacet surface (GGX, Smith's masking, Schlick's Fresnel term) under one near light and an even
 * sky. Where there is no normal map the heights' slopes stand for it, or, failing both, the slopes of
 * the color's brightness, weakly. Heights throw shadows: a few steps towards the light.
 */
export const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D colorMap, normalMap, roughnessMap, heightMap, occlusionMap, metallicMap;
uniform bool has_normal, has_roughness, has_height, has_occlusion, has_metallic, has_color;
uniform vec2 screen, size, middle;
uniform vec3 light;
uniform float scale, repeat, relief, down;
out vec4 shown;

const float PI = 3.14159265;

float heightAt(vec2 uv) {
  if (has_height) return texture(heightMap, uv).r;
  return dot(texture(colorMap, uv).rgb, vec3(0.25, 0.6, 0.15));
}

vec3 normalAt(vec2 uv) {
  if (has_normal) {
    vec3 n = texture(normalMap, uv).rgb * 2.0 - 1.0;
    n.y *= down;
    return normalize(vec3(n.xy * relief, max(n.z, 0.05)));
  }
  vec2 dx = vec2(1.0 / size.x, 0.0), dy = vec2(0.0, 1.0 / size.y);
  float strength = (has_height ? 6.0 : 1.6) * relief;
  float sx = heightAt(uv + dx) - heightAt(uv - dx);
  float sy = heightAt(uv + dy) - heightAt(uv - dy);
  return normalize(vec3(-sx * strength, -sy * strength, 1.0));
}

float lit(vec2 uv, vec3 towards) {
  if (!has_height) return 1.0;
  vec2 way = towards.xy / max(towards.z, 0.2) * 18.0 / size * relief;
  float start = heightAt(uv), shade = 0.0;
  for (int k = 1; k <= 10; k++) {
    float share = float(k) / 10.0;
    shade = max(shade, heightAt(uv + way * share) - start - share * 0.9);
  }
  return 1.0 - 0.85 * smoothstep(0.0, 0.12, shade);
}

void main() {
  vec2 pixel = vec2(gl_FragCoord.x, screen.y - gl_FragCoord.y);
  vec2 place = middle + (pixel - 0.5 * screen) / scale;
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, size * repeat))) {
    shown = vec4(0.0);
    return;
  }
  vec2 uv = place / size;
  vec4 base = texture(colorMap, uv);
  float rough = clamp(has_roughness ? texture(roughnessMap, uv).r : 0.65, 0.06, 1.0);
  float metal = has_metallic ? texture(metallicMap, uv).r : 0.0;
  float open = has_occlusion ? texture(occlusionMap, uv).r : 1.0;
  vec3 n = normalAt(uv);

  vec2 here = 2.0 * pixel / screen - 1.0;
  vec3 way = vec3((light.xy - here) * vec2(screen.x / screen.y, 1.0), light.z);
  float reach = dot(way, way);
  vec3 l = normalize(way), v = vec3(0.0, 0.0, 1.0), m = normalize(l + v);
  float nl = max(dot(n, l), 0.0), nv = max(n.z, 0.02), nm = max(dot(n, m), 0.0);

  float a = rough * rough, a2 = a * a;
  float spread = nm * nm * (a2 - 1.0) + 1.0;
  float facets = a2 / (PI * spread * spread);
  float masked = 0.5 / mix(2.0 * nl * nv, nl + nv, a);
  vec3 f0 = mix(vec3(0.04), base.rgb, metal);
  vec3 mirrored = f0 + (1.0 - f0) * pow(1.0 - max(dot(v, m), 0.0), 5.0);
  vec3 matte = base.rgb * (1.0 - metal) / PI;
  float power = 2.2 * PI / (0.55 + reach) * lit(uv, l);
  vec3 sky = (base.rgb * (1.0 - metal) + f0 * 0.6) * mix(0.16, 0.3, n.z * 0.5 + 0.5) * open;
  vec3 sum = sky * 0.7 + (matte * (1.0 - mirrored) + min(facets * masked, 24.0) * mirrored) * nl * power * mix(1.0, open, 0.5);
  sum = sum / (1.0 + max(sum - 0.8, 0.0) * 0.6);
  vec3 curve = mix(sum * 12.92, 1.055 * pow(max(sum, 1e-4), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, sum));
  shown = vec4(clamp(curve, 0.0, 1.0), 1.0);
}`;
