// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"

#include <algorithm>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kDensity = 1000;
constexpr int kSizes = 4;
constexpr double kEdges[kSizes] = {1e-3, 1, 30, 1000};  // [m]

/// The same fall in four sizes, drawn at the same size, with default settings: similar bodies move alike.
class Scales : public WorldDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		static const char* const names[kSizes] = {"cube of 1 mm", "cube of 1 m", "cube of 30 m", "cube of 1 km"};
		for (int i = 0; i < kSizes; ++i)
		{
			const double half = kEdges[i] / 2;
			if (auto error = makeSolid(m_solids[i], names[i], makeBoxMesh({half, half, half}), 500, options)) return error;
		}
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 240; }
	bool hasStockSide() const override { return true; }
	double duration() const override { return 3; }
	Viewpoint viewpoint() const override { return {{0, 0.6, 0}, 7.5, 0.3, 0.2}; }
	std::vector<Parameter> parameters() override { return {{"height of the fall over the edge", "", &m_height, 0, 2, true, false}}; }
	std::vector<Figure> figures() const override
	{
		std::vector<Figure> figures;
		for (size_t i = 0; i < kSizes; ++i)
		{
			const double weight = kDensity * m_solids[i]->tree->volume * kGravity;
			figures.push_back({m_solids[i]->name + ": force over weight", "", world(i).contactForce(m_bodies[i]).y / weight, 1, 0.01});
			figures.push_back(
				{m_solids[i]->name + ": height over that of the metre's", "", relativeHeight(i) / relativeHeight(1), 1, 1e-3});
		}
		return figures;
	}

protected:
	std::optional<Error> build() override
	{
		for (size_t i = 0; i < kSizes; ++i)
		{
			const double edge = kEdges[i];
			DemoWorld& w = addWorld({0, -kGravity, 0}, {1.5 * (double(i) - 1.5), 0, 0}, m_solids[i]->name, 1 / edge);
			w.addPlane({0, 1, 0}, 0, 0.5);
			BodySetup cube;
			cube.name = m_solids[i]->name;
			cube.density = kDensity;
			cube.colour = bodyColour(int(i));
			cube.X_WM.translation.y = (0.5 + m_height) * edge;
			// The impact speed grows with the root of the size. The dissipation is an inverse speed, so it is scaled inversely.
			cube.dissipation = 5 / std::sqrt(edge);
			m_bodies[i] = w.add(m_solids[i], std::move(cube));
			if (!m_bodies[i]) return std::nullopt;
		}
		return std::nullopt;
	}
	void decorate(const DrawChoice&, DrawList& list) override { list.gridCell = 0.5; }
	double arrowForce() const override { return kDensity * kGravity; }
	double arrowLength() const override { return 0.7; }

private:
	double relativeHeight(size_t i) const { return double(m_bodies[i]->getWorldTransform().getOrigin().y()) / kEdges[i]; }

	SolidPtr m_solids[kSizes];
	btRigidBody* m_bodies[kSizes] = {};
	double m_height = 0.3;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeScales() { return std::make_unique<Scales>(); }
}  // namespace browser
