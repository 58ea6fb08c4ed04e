// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include <utility>

namespace ist
{
size_t BodySurface::bytes() const
{
	const auto of = [](const auto& array) { return array.size() * sizeof(array[0]); };
	return of(surface.nodes) + of(surface.elements) + of(field.nodes) + of(field.cells);
}

std::string BodySurface::validate() const
{
	if (std::string fault = surface.validate(); !fault.empty()) return "surface: " + fault;
	if (std::string fault = field.validate(); !fault.empty()) return "depth field: " + fault;
	return tables.empty() ? "the query tables are missing" : "";
}

Result<BodySurface> buildBodySurface(const MeshDistance& mesh, const BodySurfaceOptions& options)
{
	return buildBodySurface(mesh, buildContactSurface(mesh.mesh(), {options.elements, options.progress}), options);
}

Result<BodySurface> buildBodySurface(const MeshDistance& mesh, Result<ContactSurface> surface, const BodySurfaceOptions& options)
{
	if (!surface) return surface.error();
	Result<DepthField> field = buildDepthField(mesh, {options.cells, options.seed, options.threads, options.progress});
	if (!field) return field.error();
	QueryTables tables = buildQueryTables(surface.value(), field.value());
	return BodySurface{std::move(surface).value(), std::move(field).value(), std::move(tables)};
}
}  // namespace ist
