// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/HeatMapTexture.h"

#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr std::uint32_t kNowhere = UINT32_MAX;
constexpr int kLargest = 16384;
/// Limits for about 5 GB of memory. The picture takes 8 bytes per texel and as much again while it is painted; the surface takes 32 bytes
/// per covered texel.
constexpr double kMostTexels = 1 << 26, kMostCovered = 1 << 27;
constexpr double kMostRepeats = 64, kFurthest = 1e6, kReach = 0.01;

/// A place in the picture, in texels from the centre of the upper left texel; y points down.
struct Place
{
	double x = 0, y = 0;
};

bool before(const Place& a, const Place& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

/// Twice the signed area of the triangle a, b, p. Exchanging a and b changes the sign and nothing else. So a centre on an edge is exactly
/// on it for both neighbours.
double side(const Place& a, const Place& b, const Place& p)
{
	if (before(b, a)) return -side(b, a, p);
	return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Whether `p` is inside the edge from a to b. A point on the edge belongs to exactly one of the two triangles that share it.
bool within(double side, const Place& a, const Place& b) { return side > 0 || (side == 0 && before(a, b)); }

/// Calls `found(x, y, weights of the corners)` for each texel whose centre lies in a triangle.
template <class Found> void forEachTexel(std::array<Place, 3> corners, const Found& found)
{
	std::array<int, 3> order{0, 1, 2};
	double twice = side(corners[0], corners[1], corners[2]);
	if (twice < 0)
	{
		std::swap(corners[1], corners[2]);
		std::swap(order[1], order[2]);
		twice = -twice;
	}
	if (!(twice > 0)) return;
	const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
	const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
	for (double y = std::ceil(top); y <= bottom; ++y)
		for (double x = std::ceil(left); x <= right; ++x)
		{
			double sides[3];
			bool inside = true;
			for (size_t c = 0; c < 3; ++c)
			{
				const Place &a = corners[(c + 1) % 3], &b = corners[(c + 2) % 3];
				sides[c] = side(a, b, {x, y});
				inside = inside && within(sides[c], a, b);
			}
			if (!inside) continue;
			double weights[3];
			for (size_t c = 0; c < 3; ++c) weights[order[c]] = sides[c] / twice;
			found(x, y, weights);
		}
}

std::uint32_t wrapped(double x, int size)
{
	const double rest = x - size * std::floor(x / size);
	return std::min(std::uint32_t(rest), std::uint32_t(size - 1));
}

double triangleArea(const Mesh& mesh, const std::array<uint32_t, 3>& t)
{
	return 0.5 * norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
}

std::optional<Error> check(const Mesh& object, const TexturedMesh& surface, const HeatMapTextureOptions& options)
{
	if (std::min(options.width, options.height) < 1 || std::max(options.width, options.height) > kLargest)
		return Error{"a texture has 1 to " + std::to_string(kLargest) + " texels on each side, not " + std::to_string(options.width) +
			" by " + std::to_string(options.height)};
	const double texels = double(options.width) * options.height;
	if (texels > kMostTexels)
		return Error{"a texture of " + std::to_string(options.width) + " by " + std::to_string(options.height) +
			" texels is too large: at most 8192 by 8192, or as many otherwise"};
	if (!(options.reach >= 0) || options.margin < 0) return Error{"margin and reach of a texture must not be negative"};
	if (object.triangles.empty()) return Error{"the heat map has no surface to paint"};
	if (surface.places.empty() || surface.places.size() != surface.mesh.triangles.size())
		return Error{"the mesh has no texture coordinates: importTexturedMesh reads them, and says how to make some"};
	double boxes = 0, covered = 0;
	for (const auto& t : surface.places)
	{
		for (const TexturePlace& place : t)
			if (!(std::fabs(place.u) <= kFurthest && std::fabs(place.v) <= kFurthest))
				return Error{"the mesh has texture coordinates that are not finite, or further than a million pictures away"};
		const auto [left, right] = std::minmax({t[0].u, t[1].u, t[2].u});
		const auto [low, high] = std::minmax({t[0].v, t[1].v, t[2].v});
		boxes += (right - left) * (high - low);
		covered += 0.5 * std::fabs((t[1].u - t[0].u) * (t[2].v - t[0].v) - (t[2].u - t[0].u) * (t[1].v - t[0].v));
	}
	if (boxes > kMostRepeats)
		return Error{"the texture repeats too often over the surface, so that each texel would show many places: unwrap the mesh"};
	if (covered * texels > kMostCovered)
		return Error{"the texture repeats so often that it covers " + std::to_string(std::llround(covered * texels)) +
			" texels, more than can be kept: take a smaller picture, or unwrap the mesh"};
	return std::nullopt;
}
}  // namespace

/// The map's object, with its nearest-point query.
class HeatMapTexture::Object
{
public:
	Object(const Mesh& object, double reach) : m_distance(object), m_reach(reach > 0 ? reach : kReach * bounds(object).longestSide()) {}

	/// Triangle, and the weights of its second and third corner; kNowhere beyond the reach.
	std::uint32_t find(const Vec3& p, float& u, float& v) const
	{
		const MeshDistance::Closest closest = m_distance.closest(p);
		if (closest.distance > m_reach) return kNowhere;
		const Mesh& mesh = m_distance.mesh();
		const auto& t = mesh.triangles[closest.triangle];
		const Vec3 a = mesh.vertices[t[0]], ab = mesh.vertices[t[1]] - a, ac = mesh.vertices[t[2]] - a, ap = closest.point - a;
		const Vec3 normal = cross(ab, ac);
		const double square = dot(normal, normal);
		u = square > 0 ? float(std::clamp(dot(cross(ap, ac), normal) / square, 0.0, 1.0)) : 0;
		v = square > 0 ? float(std::clamp(dot(cross(ab, ap), normal) / square, 0.0, 1.0)) : 0;
		return closest.triangle;
	}

private:
	MeshDistance m_distance;
	double m_reach;
};

Result<HeatMapTexture> HeatMapTexture::make(const Mesh& object, const TexturedMesh& surface, const HeatMapTextureOptions& options)
{
	if (auto error = check(object, surface, options)) return *error;
	HeatMapTexture texture;
	texture.m_width = options.width;
	texture.m_height = options.height;
	texture.m_object = meshHash(object);
	texture.m_triangles = object.triangles;
	texture.m_vertexAreas.resize(object.vertices.size());
	for (const auto& t : object.triangles)
		for (const uint32_t v : t) texture.m_vertexAreas[v] += triangleArea(object, t) / 3;
	texture.cover(surface, Object(object, options.reach));
	if (texture.m_samples.empty())
		return Error{"the texture coordinates cover no texel: each island of the texture is smaller than one; take a larger picture, or "
					 "unwrap the mesh"};
	texture.grow(options.margin);
	return texture;
}

void HeatMapTexture::cover(const TexturedMesh& surface, const Object& object)
{
	m_areas.assign(size_t(m_width) * size_t(m_height), 0);
	for (size_t t = 0; t < surface.places.size(); ++t)
	{
		const auto& corners = surface.mesh.triangles[t];
		std::array<Place, 3> places;
		for (size_t c = 0; c < 3; ++c) places[c] = {surface.places[t][c].u * m_width - 0.5, (1 - surface.places[t][c].v) * m_height - 0.5};
		const double ofTexel = triangleArea(surface.mesh, corners) / (0.5 * std::fabs(side(places[0], places[1], places[2])));
		forEachTexel(places, [&](double x, double y, const double weights[3]) {
			Sample sample{wrapped(y, m_height) * std::uint32_t(m_width) + wrapped(x, m_width), kNowhere, 0, 0, ofTexel};
			Vec3 p;
			for (size_t c = 0; c < 3; ++c) p += weights[c] * surface.mesh.vertices[corners[c]];
			sample.triangle = object.find(p, sample.u, sample.v);
			m_areas[sample.texel] += ofTexel;
			m_samples.push_back(sample);
		});
	}
}

/// Fills the margins ring by ring. Each texel copies the first neighbour that has a value: first the adjacent ones, then the diagonal ones.
/// The picture repeats at its borders.
void HeatMapTexture::grow(int margin)
{
	constexpr int kNeighbours[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
	std::vector<bool> filled(m_areas.size());
	std::vector<std::uint32_t> rim;
	for (std::uint32_t i = 0; i < m_areas.size(); ++i)
		if (m_areas[i] > 0) filled[i] = true, rim.push_back(i);
	const auto neighbour = [&](std::uint32_t texel, const int step[2]) {
		const int x = int(texel) % m_width + step[0], y = int(texel) / m_width + step[1];
		return std::uint32_t((y + m_height) % m_height * m_width + (x + m_width) % m_width);
	};
	for (int ring = 0; ring < margin; ++ring)
	{
		std::vector<std::uint32_t> next;
		for (const auto& step : kNeighbours)
			for (const std::uint32_t from : rim)
			{
				const std::uint32_t to = neighbour(from, step);
				if (filled[to]) continue;
				filled[to] = true;
				m_margin.push_back({to, from});
				next.push_back(to);
			}
		rim = std::move(next);
	}
}

template <class At> std::vector<double> HeatMapTexture::blended(double bare, const At& atVertex) const
{
	std::vector<double> sums(m_areas.size());
	for (const Sample& s : m_samples)
	{
		double value = bare;
		if (s.triangle != kNowhere)
		{
			const auto& t = m_triangles[s.triangle];
			value = (1 - double(s.u) - double(s.v)) * atVertex(t[0]) + double(s.u) * atVertex(t[1]) + double(s.v) * atVertex(t[2]);
		}
		sums[s.texel] += s.area * value;
	}
	for (size_t i = 0; i < sums.size(); ++i) sums[i] = m_areas[i] > 0 ? sums[i] / m_areas[i] : bare;
	for (const Copy& copy : m_margin) sums[copy.to] = sums[copy.from];
	return sums;
}

std::optional<Error> HeatMapTexture::checkObject(const HeatMap& map) const
{
	if (meshHash(map.mesh()) == m_object) return std::nullopt;
	return Error{"the heat map is of another object than the one that this texture was made for"};
}

Result<Picture> HeatMapTexture::colours(const HeatMap& map, HeatMapColours colours, int part) const
{
	if (auto error = checkObject(map)) return *error;
	std::vector<HeatMapColour> painted;
	for (const HeatMap::Vertex& v : map.vertices(part)) painted.push_back(heatMapColour(map, v, colours));
	const HeatMapColour bare = heatMapColour(map, {}, colours);
	Picture picture{m_width, m_height, std::vector<std::uint8_t>(3 * m_areas.size())};
	const auto paint = [&](size_t channel, std::uint8_t HeatMapColour::*member) {
		const std::vector<double> values = blended(bare.*member, [&](std::uint32_t v) { return double(painted[v].*member); });
		for (size_t i = 0; i < values.size(); ++i)
			picture.pixels[3 * i + channel] = std::uint8_t(std::lround(std::clamp(values[i], 0.0, 255.0)));
	};
	paint(0, &HeatMapColour::r);
	paint(1, &HeatMapColour::g);
	paint(2, &HeatMapColour::b);
	return picture;
}

Result<std::vector<double>> HeatMapTexture::values(const HeatMap& map, HeatMapValue value, int part) const
{
	if (auto error = checkObject(map)) return *error;
	const std::vector<HeatMap::Vertex> vertices = map.vertices(part);
	return blended(0, [&](std::uint32_t i) {
		const HeatMap::Vertex& v = vertices[i];
		switch (value)
		{
		case HeatMapValue::Contact: return v.contact;
		case HeatMapValue::Dwell: return v.dwell;
		case HeatMapValue::Impulse: return m_vertexAreas[i] > 0 ? v.impulse / m_vertexAreas[i] : 0;
		case HeatMapValue::Pressure: return v.pressure;
		case HeatMapValue::PeakPressure: return v.peak;
		}
		return 0.0;
	});
}

GreyPicture greyPicture(const HeatMapTexture& texture, const std::vector<double>& values, double full)
{
	GreyPicture picture{texture.width(), texture.height(), std::vector<std::uint16_t>(values.size())};
	for (size_t i = 0; i < values.size(); ++i)
		picture.pixels[i] = std::uint16_t(std::lround(65535 * (full > 0 ? std::clamp(values[i] / full, 0.0, 1.0) : 0)));
	return picture;
}
}  // namespace devicebridge
