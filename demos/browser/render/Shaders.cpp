// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Shaders.h"

namespace browser::shaders
{
namespace
{
const std::string kHead = "#version 330 core\n";

/// Light from the sky, from a lamp with a shadow, and weaker from the opposite side. Input and output colours are sRGB.
const std::string kLight = R"(
uniform vec3 uToLight, uEye;
uniform mat4 uShadow;
uniform sampler2DShadow uShadowMap;
uniform float uShadowTexel;
uniform int uShadowTaps;
float litShare(vec3 p, vec3 n)
{
	if (uShadowTaps == 0) return 1.0;
	vec3 s = (uShadow * vec4(p, 1.0)).xyz * 0.5 + 0.5;
	if (any(lessThan(s, vec3(0.0))) || any(greaterThan(s, vec3(1.0)))) return 1.0;
	s.z -= 0.0015 + 0.004 * (1.0 - max(dot(n, uToLight), 0.0));
	float sum = 0.0;
	for (int i = 0; i < uShadowTaps; ++i)
	{
		float a = 2.399963 * float(i), r = 2.2 * sqrt((float(i) + 0.5) / float(uShadowTaps));
		sum += texture(uShadowMap, vec3(s.xy + uShadowTexel * r * vec2(cos(a), sin(a)), s.z));
	}
	return sum / float(uShadowTaps);
}
vec3 shaded(vec3 srgb, vec3 p, vec3 n, float gloss)
{
	vec3 albedo = pow(srgb, vec3(2.2)), toEye = normalize(uEye - p), half_ = normalize(toEye + uToLight);
	float lamp = max(dot(n, uToLight), 0.0) * litShare(p, n);
	vec3 sky = mix(vec3(0.26, 0.25, 0.25), vec3(0.50, 0.55, 0.62), 0.5 + 0.5 * n.y);
	float back = max(dot(n, normalize(vec3(-uToLight.x, 0.3, -uToLight.z))), 0.0);
	vec3 c = albedo * (sky + 0.92 * lamp * vec3(1.0, 0.96, 0.90) + 0.12 * back);
	c += gloss * (0.35 * pow(max(dot(n, half_), 0.0), 60.0) * step(0.001, lamp) + 0.10 * pow(1.0 - max(dot(n, toEye), 0.0), 4.0));
	return pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2));
}
)";

const std::string kBackground = R"(
vec3 background(float height)
{
	return mix(vec3(0.965, 0.970, 0.975), vec3(0.780, 0.830, 0.885), smoothstep(0.25, 1.05, height));
}
)";
}  // namespace

std::string solidVertex()
{
	return kHead + R"(
layout(location = 0) in vec3 aPosition;
layout(location = 1) in vec3 aNormal;
layout(location = 2) in vec3 aX;
layout(location = 3) in vec3 aY;
layout(location = 4) in vec3 aZ;
layout(location = 5) in vec3 aOrigin;
layout(location = 6) in vec4 aColour;
uniform mat4 uViewProjection;
out vec3 vPosition, vNormal;
out vec4 vColour;
void main()
{
	mat3 m = mat3(aX, aY, aZ);
	vPosition = m * aPosition + aOrigin;
	// Columns are orthogonal: the inverse transpose divides each by its squared length.
	vNormal = mat3(aX / dot(aX, aX), aY / dot(aY, aY), aZ / dot(aZ, aZ)) * aNormal;
	vColour = aColour;
	gl_Position = uViewProjection * vec4(vPosition, 1.0);
}
)";
}

std::string solidFragment()
{
	return kHead + kLight + R"(
in vec3 vPosition, vNormal;
in vec4 vColour;
uniform int uGlass;
out vec4 oColour;
void main()
{
	vec3 n = normalize(vNormal);
	if (uGlass == 0)
	{
		oColour = vec4(shaded(vColour.rgb, vPosition, n, 1.0), vColour.a);
		return;
	}
	float edge = 1.0 - abs(dot(n, normalize(uEye - vPosition)));
	oColour = vec4(shaded(vColour.rgb, vPosition, n, 1.0), 0.20 + 0.60 * edge * edge * edge);
}
)";
}

std::string solidShadowFragment() { return kHead + "void main() {}\n"; }

std::string ballVertex()
{
	return kHead + R"(
layout(location = 0) in vec4 aBall;
layout(location = 1) in vec2 aShadeAndBody;
uniform samplerBuffer uBodies;
uniform mat4 uView, uProjection;
uniform float uPixels;
uniform int uOrthographic;
uniform sampler1D uRamp;
flat out vec3 vCenter;
flat out float vRadius, vFlat;
flat out vec3 vColour;
out vec3 vPosition;
void main()
{
	vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
	int body = 3 * int(aShadeAndBody.y + 0.5);
	vec4 x = texelFetch(uBodies, body), y = texelFetch(uBodies, body + 1), z = texelFetch(uBodies, body + 2), place = vec4(aBall.xyz, 1.0);
	vCenter = (uView * vec4(dot(x, place), dot(y, place), dot(z, place), 1.0)).xyz;
	vRadius = aBall.w * length(vec3(x.x, y.x, z.x));
	vColour = texture(uRamp, 0.5 / 256.0 + aShadeAndBody.x * 255.0 / 256.0).rgb;
	float d = length(vCenter), grown = vRadius;
	vec3 back = vec3(0.0, 0.0, 1.0);
	if (uOrthographic == 0)
	{
		back = -vCenter / d;
		grown = vRadius * d / sqrt(max(d * d - vRadius * vRadius, 1e-4 * d * d));
	}
	// Smaller than that, a ball is a flat dot of at least a pixel.
	float inPixels = vRadius * uPixels / d;
	vFlat = uOrthographic == 0 ? 1.0 - smoothstep(1.0, 2.0, inPixels) : 0.0;
	vec3 right = normalize(cross(abs(back.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), back)), up = cross(back, right);
	vPosition = vCenter + grown * (corner.x * right + corner.y * up);
	gl_Position = uProjection * vec4(vPosition, 1.0);
}
)";
}

namespace
{
const std::string kBall = R"(
flat in vec3 vCenter;
flat in float vRadius, vFlat;
flat in vec3 vColour;
in vec3 vPosition;
uniform mat4 uProjection;
uniform int uOrthographic;
vec3 meet(out vec3 normal)
{
	vec3 from = uOrthographic == 1 ? vec3(vPosition.xy, 0.0) : vec3(0.0);
	vec3 way = uOrthographic == 1 ? vec3(0.0, 0.0, -1.0) : normalize(vPosition);
	vec3 c = from - vCenter;
	float b = dot(c, way), disc = b * b - dot(c, c) + vRadius * vRadius;
	if (disc < 0.0) discard;
	vec3 p = from + (-b - sqrt(disc)) * way;
	normal = (p - vCenter) / vRadius;
	vec4 clip = uProjection * vec4(p, 1.0);
	gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
	return p;
}
)";
}  // namespace

std::string ballFragment()
{
	return kHead + kLight + kBall + R"(
uniform mat4 uFromView;
out vec4 oColour;
void main()
{
	vec3 n;
	vec3 p = meet(n);
	n = normalize(mix(n, normalize(-vCenter), vFlat));
	oColour = vec4(shaded(vColour, (uFromView * vec4(p, 1.0)).xyz, mat3(uFromView) * n, 0.8), 1.0);
}
)";
}

std::string ballShadowFragment()
{
	return kHead + kBall + R"(
void main()
{
	vec3 n;
	meet(n);
}
)";
}

std::string lineVertex()
{
	return kHead + R"(
layout(location = 0) in vec3 aFrom;
layout(location = 1) in vec3 aTo;
layout(location = 2) in vec4 aColour;
uniform mat4 uViewProjection;
uniform vec2 uSize;
uniform float uWidth;
out vec4 vColour;
void main()
{
	vec4 a = uViewProjection * vec4(aFrom, 1.0), b = uViewProjection * vec4(aTo, 1.0);
	vec4 p = (gl_VertexID & 1) == 0 ? a : b;
	vec2 way = (b.xy / b.w - a.xy / a.w) * uSize;
	float length_ = length(way);
	way = length_ > 0.0 && a.w > 0.0 && b.w > 0.0 ? way / length_ : vec2(1.0, 0.0);
	float side = float(gl_VertexID >> 1) * 2.0 - 1.0;
	p.xy += side * uWidth * vec2(-way.y, way.x) / uSize * p.w;
	p.z -= 0.0004 * p.w;
	vColour = aColour;
	gl_Position = p;
}
)";
}

std::string lineFragment() { return kHead + "in vec4 vColour;\nout vec4 oColour;\nvoid main() { oColour = vColour; }\n"; }

std::string groundVertex()
{
	return kHead + R"(
uniform mat4 uViewProjection;
uniform vec3 uCenter, uU, uV;
uniform float uExtent;
out vec3 vPosition;
void main()
{
	vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
	vPosition = uCenter + uExtent * (corner.x * uU + corner.y * uV);
	gl_Position = uViewProjection * vec4(vPosition, 1.0);
}
)";
}

std::string groundFragment()
{
	return kHead + kLight + kBackground + R"(
in vec3 vPosition;
uniform vec3 uCenter, uU, uV, uOrigin;
uniform float uExtent, uCell;
uniform vec2 uSize;
uniform int uWater;
out vec4 oColour;
float gridLine(vec2 at)
{
	vec2 wide = fwidth(at), off = abs(fract(at - 0.5) - 0.5) / max(wide, 1e-6);
	float line = 1.0 - min(min(off.x, off.y) / 1.2, 1.0);
	return line * (1.0 - smoothstep(0.15, 0.5, max(wide.x, wide.y)));
}
void main()
{
	vec3 n = cross(uV, uU);
	if (n.y < 0.0) n = -n;
	vec2 at = vec2(dot(vPosition - uOrigin, uU), dot(vPosition - uOrigin, uV)) / uCell;
	float fade = smoothstep(0.25, 1.0, length(vPosition - uCenter) / uExtent);
	vec3 far = background(gl_FragCoord.y / uSize.y);
	if (uWater == 1)
	{
		float grazing = pow(1.0 - abs(dot(n, normalize(uEye - vPosition))), 3.0);
		vec3 c = mix(vec3(0.20, 0.48, 0.66), vec3(0.80, 0.90, 0.96), 0.15 + 0.6 * grazing);
		c = mix(c, vec3(0.93, 0.97, 1.0), 0.25 * gridLine(at));
		oColour = vec4(mix(c, far, fade), mix(0.50 + 0.35 * grazing, 1.0, fade));
		return;
	}
	float line = max(0.30 * gridLine(at), 0.55 * gridLine(at / 10.0));
	vec3 c = mix(vec3(0.905, 0.912, 0.920), vec3(0.52, 0.56, 0.62), line);
	c *= mix(0.66, 1.0, litShare(vPosition, n));
	oColour = vec4(mix(c, far, fade), 1.0);
}
)";
}

std::string screenVertex()
{
	return kHead + R"(
out vec2 vAt;
void main()
{
	vAt = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0;
	gl_Position = vec4(vAt * 2.0 - 1.0, 0.0, 1.0);
}
)";
}

std::string backgroundFragment()
{
	return kHead + kBackground + "in vec2 vAt;\nout vec4 oColour;\nvoid main() { oColour = vec4(background(vAt.y), 1.0); }\n";
}

std::string occlusionFragment()
{
	return kHead + R"(
// Each pixel asks its neighbours how much of its sky they hide (the estimator of McGuire and others, "The Alchemy screen-space ambient
// obscurance algorithm", 2011).
in vec2 vAt;
uniform sampler2D uDepth;
uniform mat4 uFromClip;
uniform float uReach, uAspect, uHeightShare;
out float oShare;
vec3 viewed(vec2 at)
{
	// A depth belongs to the middle of its texel.
	vec2 size = vec2(textureSize(uDepth, 0));
	ivec2 texel = ivec2(clamp(floor(at * size), vec2(0.0), size - 1.0));
	vec4 p = uFromClip * vec4(vec3((vec2(texel) + 0.5) / size, texelFetch(uDepth, texel, 0).r) * 2.0 - 1.0, 1.0);
	return p.xyz / p.w;
}
void main()
{
	vec2 texel = 1.0 / vec2(textureSize(uDepth, 0)), here = vAt + 0.25 * texel;
	if (textureLod(uDepth, here, 0.0).r >= 1.0) { oShare = 1.0; return; }
	vec3 p = viewed(here);
	vec3 r = viewed(here + vec2(texel.x, 0.0)) - p, l = p - viewed(here - vec2(texel.x, 0.0));
	vec3 u = viewed(here + vec2(0.0, texel.y)) - p, d = p - viewed(here - vec2(0.0, texel.y));
	vec3 n = normalize(cross(abs(r.z) < abs(l.z) ? r : l, abs(u.z) < abs(d.z) ? u : d));
	float turned = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
	float across = uReach * uHeightShare / -p.z, sum = 0.0;
	const int kSamples = 14;
	for (int i = 0; i < kSamples; ++i)
	{
		float t = (float(i) + 0.5) / float(kSamples), a = turned + 6.2831853 * 3.0 * t;
		vec3 v = viewed(here + across * t * vec2(cos(a) / uAspect, sin(a))) - p;
		float vv = dot(v, v);
		float near_ = max(1.0 - vv / (uReach * uReach), 0.0);
		sum += near_ * near_ * max(dot(v, n) - 0.02 * uReach - 0.002 * -p.z, 0.0) * inversesqrt(vv + 1e-4 * uReach * uReach);
	}
	oShare = clamp(1.0 - 2.1 * sum / float(kSamples), 0.0, 1.0);
}
)";
}

std::string composeFragment()
{
	return kHead + R"(
in vec2 vAt;
uniform sampler2D uColour, uShare, uDepth;
uniform int uOcclusion;
out vec4 oColour;
void main()
{
	vec3 c = texture(uColour, vAt).rgb;
	float share = 1.0;
	if (uOcclusion == 1)
	{
		vec2 texel = 1.0 / vec2(textureSize(uShare, 0));
		float own = texture(uDepth, vAt).r, sum = 0.0, weight = 0.0;
		for (int y = -1; y <= 2; ++y)
			for (int x = -1; x <= 2; ++x)
			{
				vec2 at = vAt + (vec2(x, y) - 0.5) * texel;
				float w = exp(-abs(texture(uDepth, at).r - own) / (0.02 * (1.0 - own) + 1e-5));
				sum += w * texture(uShare, at).r;
				weight += w;
			}
		share = sum / max(weight, 1e-4);
	}
	oColour = vec4(c * mix(vec3(0.20, 0.20, 0.24), vec3(1.0), share), 1.0);
}
)";
}
}  // namespace browser::shaders
