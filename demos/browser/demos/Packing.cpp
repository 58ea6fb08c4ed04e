// SPDX-License-Identifier: Zlib
#include "demos/browser/base/DemoSolid.h"

#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <algorithm>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kSize = 0.2, kGrows = 4;

/// A mesh is filled with spheres, the largest first. Every first part of the list is a packing.
class Packing : public BrowsableDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Result<Mesh> mesh = chosenMesh(options, kSize, knotMesh(kSize));
		if (!mesh) return mesh.error();
		if (auto error = makeSolid(m_solid, "body", mesh.value(), 3000, options)) return error;
		m_most = double(m_solid->tree->spheres.size());
		judge();
		return std::nullopt;
	}
	std::optional<Error> restart() override
	{
		m_time = 0;
		m_fill.values.clear();
		return std::nullopt;
	}
	void step(double seconds) override
	{
		m_time += seconds;
		if (m_fill.values.size() < 600 && m_time >= double(m_fill.values.size()) / 60)
			m_fill.values.push_back(float(100 * filled(shown())));
	}
	double stepSize() const override { return 1.0 / 60; }
	double duration() const override { return kGrows; }
	double time() const override { return m_time; }
	Viewpoint viewpoint() const override
	{
		const double height = bounds(m_solid->mesh).size().y;
		return {{0, 0.5 * height, 0}, std::max(0.42, 2.9 * height), 0.5, height > 0.12 ? 0.3 : 0.6};
	}
	DrawChoice firstChoice() const override { return {.spheres = true}; }
	void draw(const DrawChoice& choice, DrawList& list) override
	{
		list.ground = choice.ground;
		list.shadows = choice.shadows;
		list.wireframe = choice.wireframe;
		list.gridCell = 0.02;
		Pose X;
		X.translation.y = -bounds(m_solid->mesh).lower.y;
		if (choice.surfaces) list.surfaces.push_back({m_solid->surface, X, bodyColour(0), 1, true});
		m_solid->spheres.draw(choice, X, list, shown());
		addSphereKeys({}, list);
	}
	std::vector<Parameter> parameters() override
	{
		return {{"spheres", "", &m_most, 1, double(m_solid->tree->spheres.size()), false, true}};
	}
	std::vector<Figure> figures() const override
	{
		return {{"spheres", "", double(shown())}, {"volume filled", "%", 100 * filled(shown())},
			{"pairs of spheres that overlap", "", double(m_overlapping), 0, 0}, {"spheres that protrude", "", double(m_protruding), 0, 0}};
	}
	std::vector<Curve> curves() const override { return {m_fill}; }

private:
	size_t shown() const
	{
		const double share = std::min(1.0, m_time / kGrows);
		// The number grows exponentially, because the first spheres are seen best.
		return std::max<size_t>(1, size_t(std::pow(m_most, share) + 0.5));
	}
	double filled(size_t count) const
	{
		double volume = 0;
		for (size_t i = 0; i < std::min(count, m_solid->tree->spheres.size()); ++i)
			volume += 4.18879020478639098462 * std::pow(double(m_solid->tree->spheres[i].r), 3);
		return volume / massProperties(m_solid->mesh).volume;
	}
	/// Checks every sphere against every other and every triangle, in double.
	void judge()
	{
		m_overlapping = m_protruding = 0;
		const auto& spheres = m_solid->tree->spheres;
		const size_t count = std::min<size_t>(spheres.size(), 3000), triangles = m_solid->mesh.triangles.size();
		for (size_t i = 0; i < count; ++i)
			for (size_t j = 0; j < i; ++j)
			{
				const double reach = double(spheres[i].r) + spheres[j].r;
				m_overlapping += squaredNorm(spheres[i].center() - spheres[j].center()) < reach * reach;
			}
		// Only a sample is checked where all pairs would take seconds.
		const size_t stride = std::max<size_t>(1, count * triangles / 4000000);
		for (size_t i = 0; i < count; i += stride)
		{
			const Vec3 c = m_solid->tree->origin + spheres[i].center();
			double nearest = 1e300;
			for (const auto& t : m_solid->mesh.triangles)
				nearest = std::min(nearest,
					squaredNorm(closestPointOnTriangle(
									c, m_solid->mesh.vertices[t[0]], m_solid->mesh.vertices[t[1]], m_solid->mesh.vertices[t[2]]) -
						c));
			m_protruding += std::sqrt(nearest) < double(spheres[i].r) * (1 - 1e-12);
		}
	}

	SolidPtr m_solid;
	Curve m_fill{"filled", "%", {}};
	double m_time = 0, m_most = 1;
	long long m_overlapping = 0, m_protruding = 0;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makePacking() { return std::make_unique<Packing>(); }
}  // namespace browser
