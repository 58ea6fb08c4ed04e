// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Distance/MeshDistance.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace devicebridge
{
/// One contact between a part and the object at one moment.
struct HeatMapContact
{
	ist::Pose X_OP;      ///< pose of the part's mesh in the object's mesh
	double force = 0;    ///< magnitude of the sum of the normal forces, without friction [N]
	ist::Vec3 point;     ///< point of contact in the object's mesh [m]; used if the contact is too small for the mesh
	double seconds = 0;  ///< time that the moment represents [s]
};

/// Effect of one contact on the surface.
struct HeatMapTouch
{
	double area = 0;      ///< area of the object's surface inside the part [m^2]
	double depthSum = 0;  ///< thickness of the overlap, integrated over that area [m^3]; in flat contact the force is k times it
	double depth = 0;     ///< largest thickness at a vertex [m]
	double pressure = 0;  ///< largest pressure at a vertex [Pa]; for a contact smaller than a vertex's own area, its force over that area
};

/// Places, durations and pressures of the contact of parts with the surface of an object, over any number of grasps.
///
/// The force of a contact is that of the query, the sum over its pairs. It is spread over the part of the object's surface that lies inside
/// the other body. The weight at each point is the thickness of that body below it, found from its closest surface points. In flat contact
/// this is the pressure of the pressure field law, k times the thickness. The forces of the vertices sum to the force of the contact. The
/// area ends where the depth, linear on each triangle, is zero. The mesh's own triangles are the resolution: a contact that contains no
/// vertex is assigned to the vertex nearest to its point.
class HeatMap
{
public:
	/// `object` is closed and oriented. Neither it nor the parts' meshes need a tree.
	explicit HeatMap(ist::Mesh object);
	~HeatMap();
	HeatMap(const HeatMap&) = delete;
	HeatMap& operator=(const HeatMap&) = delete;

	/// Adds a part offline. Returns the index that identifies the part from now on.
	int addPart(const std::string& name, int id, ist::Mesh mesh);
	/// Begins a new grasp, to which the following contacts belong. The first grasp begins by itself.
	void beginGrasp();

	/// Adds a contact. Poses that are not rigid and numbers that are not finite are ignored. No allocation; O(vertices near the part), with
	/// one closest-point query each: about 100 us for a fingertip on vertices 1 mm apart.
	HeatMapTouch add(int part, const HeatMapContact& contact) noexcept;

	/// Adds a contact in steps: call `begin`, then `advance` until it returns true. Only then is the contact in the map. Another begin() or
	/// add() before that discards it.
	void begin(int part, const HeatMapContact& contact) noexcept;
	/// Continues for `budget` closest-point queries, about 0.5 us each, and until its present vertex is finished. Afterwards `budget` is
	/// the number left. Returns true if the contact is done or none was begun.
	bool advance(int& budget) noexcept;

	struct Vertex
	{
		double contact = 0;   ///< share of the grasps in which the vertex was touched, 0 to 1
		double dwell = 0;     ///< time of contact, summed over the parts [s]
		double impulse = 0;   ///< impulse normal to the surface [N s]
		double pressure = 0;  ///< mean pressure while it was touched [Pa]
		double peak = 0;      ///< largest pressure [Pa]
		int part = -1;        ///< part that touched it longest; -1: none
	};
	std::vector<Vertex> vertices() const;
	/// The vertices as one part touched them; negative: all parts. For a part that does not exist they are untouched.
	std::vector<Vertex> vertices(int part) const;

	struct Summary
	{
		std::string name;
		int id = 0, grasps = 0;               ///< GRAB id or other label; number of grasps in which the part touched
		double area = 0;                      ///< area of the surface that the part ever touched [m^2]
		double dwell = 0;                     ///< time of contact [s]
		double meanForce = 0, peakForce = 0;  ///< mean and largest force while it touched [N]
		double impulse = 0;                   ///< impulse [N s]
		double depth = 0;                     ///< largest depth [m]
		double peakPressure = 0;              ///< largest pressure [Pa]
	};
	std::vector<Summary> summary() const;

	const ist::Mesh& mesh() const;
	int grasps() const { return m_grasps; }
	int parts() const;
	const std::string& partName(int part) const;
	int partId(int part) const;

private:
	struct Part;
	struct Surface;
	double depthOf(uint32_t vertex) noexcept;
	void beginCollecting(const Part& part) noexcept;
	bool collect(const Part& part) noexcept;
	bool cut() noexcept;
	void finish() noexcept;
	void enter(Part& part, uint32_t vertex, double force, double pressure, double seconds, HeatMapTouch& touch) noexcept;
	void enterArea(Part& part, const HeatMapContact& contact, double scale, HeatMapTouch& touch) noexcept;
	void enterPoint(Part& part, const HeatMapContact& contact, HeatMapTouch& touch) noexcept;
	Vertex merged(uint32_t vertex, int part) const;

	std::unique_ptr<Surface> m_surface;
	std::vector<std::unique_ptr<Part>> m_parts;
	HeatMapTouch m_touch;
	int m_grasps = 1;
};
}  // namespace devicebridge
