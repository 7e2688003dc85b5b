// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What the graphics card does: displacement and stress are summed from the modes for every vertex, then coloured and lit.

/** Vertices in a row of the textures that hold shapes and stresses: four 16-bit numbers each. */
export const textureWidth = 1024;

/** What the shaders share: weights of the shapes, magnification, what is coloured. */
const deform = /* glsl */ `
  precision highp isampler2DArray;
  uniform isampler2DArray uShapes;
  uniform isampler2DArray uStress;
  uniform int uStressLayers;    // of each shape: 0 none, 1 von Mises, 2 the six components
  uniform sampler2D uWeights;   // one texel for each shape in use: weight times scale, layer, weight times stress scale
  uniform int uCount;
  uniform float uMagnify;       // times the deformation, for the drawn position only
  uniform vec3 uShift, uTurn, uPivot;  // motion of the frame from which the deformation counts: at uPivot
  uniform int uSeen;            // 1: coloured by the way from uThen * place to uNow * moved place
  uniform mat4 uNow, uThen;
  uniform int uField;           // 0 none, 1 magnitude, 2, 3, 4 along x, y, z, 5 von Mises stress, 6 given (of faces)
  uniform vec2 uRange;          // of the colour scale
  in float vertex;
  vec3 displacement() {
    int v = int(vertex + 0.5);
    ivec2 at = ivec2(v % ${textureWidth}, v / ${textureWidth});
    vec3 u = vec3(0.0);
    for (int i = 0; i < uCount; ++i) {
      vec2 w = texelFetch(uWeights, ivec2(i, 0), 0).xy;
      u += w.x * vec3(texelFetch(uShapes, ivec3(at, int(w.y + 0.5)), 0).xyz);
    }
    return u;
  }
  vec3 carried(vec3 x) {        // by that frame
    return uShift + cross(uTurn, x - uPivot);
  }
  vec3 shown(vec3 x, vec3 u) {  // the displacement that is coloured; u of the surface's own
    return uSeen == 1 ? (uNow * vec4(x + u, 1.0) - uThen * vec4(x, 1.0)).xyz : u - carried(x);
  }
  float vonMises() {
    int v = int(vertex + 0.5);
    ivec2 at = ivec2(v % ${textureWidth}, v / ${textureWidth});
    vec3 normal_ = vec3(0.0), shear = vec3(0.0);
    for (int i = 0; i < uCount; ++i) {
      vec3 w = texelFetch(uWeights, ivec2(i, 0), 0).xyz;
      int layer = uStressLayers * int(w.y + 0.5);
      normal_ += w.z * vec3(texelFetch(uStress, ivec3(at, layer), 0).xyz);
      if (uStressLayers == 2) shear += w.z * vec3(texelFetch(uStress, ivec3(at, layer + 1), 0).xyz);
    }
    if (uStressLayers == 1) return abs(normal_.x);
    vec3 d = normal_ - normal_.yzx;
    return sqrt(0.5 * dot(d, d) + 3.0 * dot(shear, shear));
  }
  float field(vec3 u) {
    float f = uField == 5 ? vonMises() : uField == 1 ? length(u) : uField == 2 ? u.x : uField == 3 ? u.y : u.z;
    return (f - uRange.x) / max(uRange.y - uRange.x, 1e-30);
  }`;

export const surfaceVertex = /* glsl */ `${deform}
  uniform float uPush;          // a ghost's: farther from the eye, at the same place of the screen
  in float paint, given;
  out vec3 vNormal0, vPlace0, vPlace, vBody;
  out float vField, vPaint;
  void main() {
    vec3 u = displacement();
    vField = uField == 6 ? (given - uRange.x) / max(uRange.y - uRange.x, 1e-30) : uField > 0 ? field(shown(position, u)) : 0.0;
    vPaint = paint;
    vBody = position;
    vNormal0 = normalMatrix * normal;
    vPlace0 = (modelViewMatrix * vec4(position, 1.0)).xyz;
    vec3 r = carried(position);
    vec4 place = modelViewMatrix * vec4(position + r + uMagnify * (u - r), 1.0);
    vPlace = place.xyz;
    place.xyz *= 1.0 + uPush;
    gl_Position = projectionMatrix * place;
  }`;

export const surfaceFragment = /* glsl */ `
  precision highp float;
  uniform vec3 uColor, uAccent;
  uniform float uOpacity, uPaint;
  uniform int uField;
  uniform sampler2D uScale;
  uniform vec4 uCut;            // what lies on the far side of n . x = d is cut away; n = 0: nothing
  in vec3 vNormal0, vPlace0, vPlace, vBody;
  in float vField, vPaint;
  out vec4 color;
  void main() {
    if (dot(uCut.xyz, vBody) > uCut.w && dot(uCut.xyz, uCut.xyz) > 0.0) discard;
    // The smooth normal of the undeformed face turns with the flat normal of the triangle under this pixel.
    vec3 flat0 = normalize(cross(dFdx(vPlace0), dFdy(vPlace0)));
    vec3 flat1 = normalize(cross(dFdx(vPlace), dFdy(vPlace)));
    vec3 toEye = normalize(-vPlace);
    if (dot(flat1, toEye) < 0.0) { flat1 = -flat1; }
    vec3 n0 = normalize(vNormal0);
    if (dot(flat0, n0) < 0.0) flat0 = -flat0;
    bool inside = !gl_FrontFacing;
    vec3 turned = inside ? -flat1 : flat1;
    vec3 n = normalize(n0 + (turned - flat0));
    if (any(isnan(n))) n = turned;
    if (inside) n = -n;
    vec3 base = uColor;
    if (uField > 0) base = texture(uScale, vec2(clamp(vField, 0.002, 0.998), 0.5)).rgb;
    else if (vPaint > 0.5) base = mix(base, uAccent, uPaint);
    if (inside) base = mix(base, vec3(0.35, 0.38, 0.42), 0.6);
    vec3 key = normalize(vec3(0.35, 0.55, 0.75));
    vec3 fill = normalize(vec3(-0.7, -0.2, 0.45));
    float light = 0.50 + 0.46 * max(dot(n, key), 0.0) + 0.16 * max(dot(n, fill), 0.0) + 0.06 * n.y;
    vec3 half_ = normalize(key + toEye);
    float shine = (uField > 0 ? 0.05 : 0.16) * pow(max(dot(n, half_), 0.0), 36.0);
    float rim = 0.10 * pow(1.0 - max(dot(n, toEye), 0.0), 3.0);
    color = vec4(base * light + shine - rim * base, uOpacity);
  }`;

export const lineVertex = /* glsl */ `${deform}
  uniform float uPull, uPoint;
  out float vField;
  out vec3 vBody;
  void main() {
    vec3 u = displacement();
    vField = uField > 0 ? field(shown(position, u)) : 0.0;
    vBody = position;
    vec3 r = carried(position);
    vec4 place = modelViewMatrix * vec4(position + r + uMagnify * (u - r), 1.0);
    place.xyz *= 1.0 - uPull;   // a little towards the eye, out of the surface
    gl_Position = projectionMatrix * place;
    gl_PointSize = uPoint;
  }`;

export const lineFragment = /* glsl */ `
  precision highp float;
  uniform vec3 uColor;
  uniform float uOpacity;
  uniform int uField;
  uniform sampler2D uScale;
  uniform vec4 uCut;
  in float vField;
  in vec3 vBody;
  out vec4 color;
  void main() {
    if (dot(uCut.xyz, vBody) > uCut.w && dot(uCut.xyz, uCut.xyz) > 0.0) discard;
    vec3 base = uField > 0 ? texture(uScale, vec2(clamp(vField, 0.002, 0.998), 0.5)).rgb : uColor;
    color = vec4(base, uOpacity);
  }`;
