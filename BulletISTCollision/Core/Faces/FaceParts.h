// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Faces/ContactFaces.h"

#include <cstdint>

namespace ist
{
/// Finds which faces of a contact hang together: those that come near to each other. Faces are entered into the cells of a grid, and faces
/// in one cell belong together.
class FaceParts
{
public:
	/// `faces`: largest number of faces.
	explicit FaceParts(size_t faces);
	/// Makes all memory resident.
	void makeResident();

	/// Numbers the parts in the order of their first faces. Call `add` for each face, then `find`.
	void clear() { m_count = 0; }
	void add(const ContactFace& face);
	/// Returns the number of parts. O(faces).
	uint32_t find();
	/// Part of a face, in the order in which faces were added.
	uint32_t of(size_t face) const { return m_part[face]; }

private:
	/// The box around a face.
	struct Extent
	{
		float x, y, z;                 ///< center
		float alongX, alongY, alongZ;  ///< half lengths
		float radius;
	};
	struct Entry
	{
		int32_t x, y, z;
		uint32_t face;  ///< kNone: free
	};
	static constexpr uint32_t kNone = UINT32_MAX;

	float cellSize();
	void enter(uint32_t face, float perSize);
	void enterCell(uint32_t face, int32_t x, int32_t y, int32_t z);
	uint32_t rootOf(uint32_t face);

	DemandZeroArray<Extent> m_extents;
	DemandZeroArray<Entry> m_table;  // open addressing
	DemandZeroArray<uint32_t> m_parent, m_part;
	DemandZeroArray<float> m_radii;
	size_t m_count = 0, m_mask = 0, m_used = 0;
};
}  // namespace ist
