// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Faces/FaceParts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ist
{
namespace
{
constexpr float kReach = 1.5f;      // radius that a face counts with, of that of a disc of its area
constexpr double kVariances = 8;    // square of the distance of a triangle's corner from its centroid, of the variance along the height
constexpr float kCellRadii = 4;     // side of a cell of the grid, of the median radius
constexpr float kLargestRadii = 2;  // largest half length of a face, in cells
constexpr size_t kEntriesPerFace = 8;
}  // namespace

FaceParts::FaceParts(size_t faces) : m_extents(faces), m_parent(faces), m_part(faces), m_radii(faces)
{
	size_t entries = 64;
	while (entries < 2 * kEntriesPerFace * faces) entries *= 2;
	m_table = DemandZeroArray<Entry>(entries);
}

void FaceParts::makeResident()
{
	m_extents.touch();
	m_table.touch();
	m_parent.touch();
	m_part.touch();
	m_radii.touch();
}

void FaceParts::add(const ContactFace& face)
{
	// A disc of the face's area reaches too short along a sliver.
	const float radius = kReach * float(std::sqrt(face.area / std::numbers::pi));
	const auto along = [&](double second) { return std::max(radius, float(std::sqrt(kVariances * std::max(second, 0.0) / face.area))); };
	m_extents[m_count++] = {float(face.center.x), float(face.center.y), float(face.center.z), along(face.second.xx), along(face.second.yy),
		along(face.second.zz), radius};
}

uint32_t FaceParts::rootOf(uint32_t face)
{
	while (m_parent[face] != face) face = m_parent[face] = m_parent[m_parent[face]];
	return face;
}

float FaceParts::cellSize()
{
	float largest = 0;
	for (size_t i = 0; i < m_count; ++i)
	{
		const Extent& e = m_extents[i];
		m_radii[i] = e.radius;
		largest = std::max({largest, e.alongX, e.alongY, e.alongZ});
	}
	float* const middle = m_radii.data() + m_count / 2;
	std::nth_element(m_radii.data(), middle, m_radii.data() + m_count);
	return std::max(kCellRadii * *middle, largest / kLargestRadii);
}

/// Enters a face into all cells that its box meets, and joins it with those that are there.
void FaceParts::enter(uint32_t face, float perSize)
{
	const Extent& e = m_extents[face];
	// std::floor is a call where the compiler may not use SSE4.
	const auto cell = [&](float at) {
		const float place = at * perSize;
		const int32_t towardsZero = int32_t(place);
		return towardsZero - (float(towardsZero) > place);
	};
	const int32_t lower[3] = {cell(e.x - e.alongX), cell(e.y - e.alongY), cell(e.z - e.alongZ)},
				  upper[3] = {cell(e.x + e.alongX), cell(e.y + e.alongY), cell(e.z + e.alongZ)};
	for (int32_t x = lower[0]; x <= upper[0]; ++x)
		for (int32_t y = lower[1]; y <= upper[1]; ++y)
			for (int32_t z = lower[2]; z <= upper[2]; ++z) enterCell(face, x, y, z);
}

void FaceParts::enterCell(uint32_t face, int32_t x, int32_t y, int32_t z)
{
	size_t at = (size_t(uint32_t(x)) * 73856093u ^ size_t(uint32_t(y)) * 19349663u ^ size_t(uint32_t(z)) * 83492791u) & m_mask;
	for (;; at = (at + 1) & m_mask)
	{
		Entry& entry = m_table[at];
		if (entry.face == kNone)
		{
			// A full table leaves faces apart; it is larger than any contact needs.
			if (++m_used < m_mask) entry = {x, y, z, face};
			return;
		}
		if (entry.x != x || entry.y != y || entry.z != z) continue;
		const uint32_t a = rootOf(entry.face), b = rootOf(face);
		m_parent[std::max(a, b)] = std::min(a, b);
		return;
	}
}

uint32_t FaceParts::find()
{
	if (m_count == 0) return 0;
	const float size = cellSize();
	if (!(size > 0)) return 0;
	size_t entries = 64;
	while (entries < 2 * kEntriesPerFace * m_count) entries *= 2;
	m_mask = std::min(entries, m_table.size()) - 1;
	m_used = 0;
	for (size_t i = 0; i <= m_mask; ++i) m_table[i].face = kNone;
	for (uint32_t i = 0; i < m_count; ++i) m_parent[i] = i;
	for (uint32_t i = 0; i < m_count; ++i) enter(i, 1 / size);
	uint32_t parts = 0;
	for (uint32_t i = 0; i < m_count; ++i)
	{
		const uint32_t root = rootOf(i);
		m_part[i] = root == i ? parts++ : m_part[root];
	}
	return parts;
}
}  // namespace ist
