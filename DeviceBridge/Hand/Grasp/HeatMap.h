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
	ist::Pose X_OP;      ///< of the part's mesh in the object's mesh
	double force = 0;    ///< magnitude of the sum of what presses, without friction [N]
	ist::Vec3 point;     ///< where, in the object's mesh: used where the contact is too small for the mesh [m]
	double seconds = 0;  ///< for how long the moment stands
};

/// What a contact did to the surface.
struct HeatMapTouch
{
	double area = 0;      ///< of the object's surface inside of the part [m^2]
	double depthSum = 0;  ///< thickness of the overlap, summed over that area: in flat contact the force is k times it [m^3]
	double depth = 0;     ///< largest thickness at a vertex [m]
	double pressure = 0;  ///< largest at a vertex; of a contact smaller than a vertex's own area, its force over that area [Pa]
};

/// Where, for how long and how strongly parts pressed on the surface of an object, over any number of grasps.
///
/// The force of a contact is that of the query, the sum over its pairs. It is spread over the part of the object's surface that lies inside
/// of the other body, in proportion to how thick that body is below each point, found from its closest surface points: in flat contact the
/// pressure of the pressure field law, k times the thickness. What the vertices get sums to that force. The area ends where the depth,
/// linear on each triangle, is zero. The mesh's own triangles are the resolution: a contact that holds no vertex goes to the vertex nearest
/// to its point.
class HeatMap
{
public:
	/// Neither mesh needs a tree. `object` is closed and oriented.
	explicit HeatMap(ist::Mesh object);
	~HeatMap();
	HeatMap(const HeatMap&) = delete;
	HeatMap& operator=(const HeatMap&) = delete;

	/// Offline. The index by which the part is called from here on.
	int addPart(const std::string& name, int id, ist::Mesh mesh);
	/// What comes now belongs to a new grasp; the first begins by itself.
	void beginGrasp();

	/// Poses that are not rigid and numbers that are not finite count for nothing. No allocation; O(vertices near the part), a closest
	/// point for each: some 100 us for a fingertip on vertices 1 mm apart.
	HeatMapTouch add(int part, const HeatMapContact& contact) noexcept;

	/// The same in shares: `begin`, and then `advance` until it is true. The contact counts when it is done; whatever is begun or added
	/// before that takes its place.
	void begin(int part, const HeatMapContact& contact) noexcept;
	/// Goes on until `looks` closest points were found, of some 0.5 us each, and to the end of the vertex that it is at; `looks` is what is
	/// left of them. True when done, and where nothing was begun.
	bool advance(int& looks) noexcept;

	struct Vertex
	{
		double contact = 0;   ///< share of the grasps in which it was touched, 0 to 1
		double dwell = 0;     ///< summed over the parts [s]
		double impulse = 0;   ///< normal to the surface [N s]
		double pressure = 0;  ///< mean while it was touched [Pa]
		double peak = 0;      ///< [Pa]
		int part = -1;        ///< that touched it longest; -1: none
	};
	std::vector<Vertex> vertices() const;
	/// Of one part alone; negative: all. Of a part that is not there nothing.
	std::vector<Vertex> vertices(int part) const;

	struct Summary
	{
		std::string name;
		int id = 0, grasps = 0;               ///< in how many it touched
		double area = 0;                      ///< of the surface that it ever touched [m^2]
		double dwell = 0;                     ///< [s]
		double meanForce = 0, peakForce = 0;  ///< while it touched [N]
		double impulse = 0;                   ///< [N s]
		double depth = 0;                     ///< largest [m]
		double peakPressure = 0;              ///< [Pa]
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
