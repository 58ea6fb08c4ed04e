// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/ImportChecks.h"

#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"

#include <algorithm>
#include <cmath>

namespace ist
{
bool ImportProgress::reach(double fraction)
{
	m_fraction = std::clamp(fraction, m_fraction, 1.0);
	m_cancelled = m_cancelled || (m_progress && !m_progress("import", m_fraction));
	return !m_cancelled;
}

Error takesTooMuchMemory(const std::string& path)
{
	return {path +
		": reading it takes far more memory than a file of its size needs, or than this machine has to spare; it is damaged: export it "
		"again, or set BULLETHAPTICS_IMPORT_MEGABYTES to the memory that it may take"};
}

double blur(const Box& box)
{
	double farthest = 0;
	for (int axis = 0; axis < 3; ++axis) farthest = std::max({farthest, std::fabs(box.lower[axis]), std::fabs(box.upper[axis])});
	const double longest = box.longestSide();
	return longest > 0 ? farthest * 0x1p-23 / longest : 0;
}

std::optional<Error> whyUnusable(const Mesh& mesh, const std::string& path, double worstBlur)
{
	if (const std::string where = whereNotFinite(mesh); !where.empty()) return Error{path + ": " + where + "; export the mesh again"};
	if (mesh.triangles.empty()) return Error{path + " contains no triangles; export the surface as polygons"};
	if (worstBlur > kBlurred)
		return Error{path + ": the mesh lies so far from its origin, " + extent(bounds(mesh)) +
			", that its coordinates, read in single precision, are exact to " + number(100 * worstBlur) +
			" % of its size only; move it to the origin and export it again"};
	return std::nullopt;
}

std::optional<Error> notFinitePlace(const TexturedMesh& textured, const std::string& path)
{
	for (std::size_t t = 0; t < textured.places.size(); ++t)
		for (const TexturePlace& place : textured.places[t])
			if (!std::isfinite(place.u) || !std::isfinite(place.v))
				return Error{path + ": the texture coordinates of triangle " + std::to_string(t) + " at " +
					ist::place(textured.mesh.vertices[textured.mesh.triangles[t][0]]) + " are not finite; export the mesh again"};
	return std::nullopt;
}
}  // namespace ist
