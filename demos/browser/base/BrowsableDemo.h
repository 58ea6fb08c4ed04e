// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/MeshAxes.h"
#include "demos/browser/drawing/DrawChoice.h"
#include "demos/browser/drawing/DrawList.h"
#include "demos/scenes/Pages/HtmlReport.h"

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace devicebridge
{
class Device;
}

namespace browser
{
/// A result of a demo. `expected` comes from a closed form, a law of physics or an integration that shares no code with the library. If
/// it is set, the demo passes only while the value is within `tolerance` of it.
struct Figure
{
	std::string name, unit;
	double value = 0;
	double expected = std::numeric_limits<double>::quiet_NaN();
	double tolerance = 0;  ///< largest error, in the figure's unit

	bool judged() const { return !std::isnan(expected); }
	bool ok() const { return std::isfinite(value) && (!judged() || std::fabs(value - expected) <= tolerance); }
};

/// A number that the user can change while the demo runs.
struct Parameter
{
	std::string name, unit;
	double* value = nullptr;
	double least = 0, most = 1;
	bool restarts = false;  ///< true: takes effect only at the next restart
	bool logarithmic = false;
};

/// A line over time.
struct Curve
{
	std::string name, unit;
	std::vector<float> values;    ///< one value for every 1/60 s of the demo's own time, the newest last
	std::vector<float> errors{};  ///< half lengths of the error bars, one for each value; may be empty
};

/// Initial position of the camera.
struct Viewpoint
{
	ist::Vec3 target;
	double distance = 1;
	double yaw = 0.6, pitch = 0.35;  ///< angles about y and above the horizon [rad]
};

constexpr double kDegree = 0.017453292519943295;  ///< [rad]

/// Settings of a demo's contact cache (btISTContactCache).
struct ContactCacheChoice
{
	bool on = true;
	double maxError = 0.05;
	/// force error that coarser levels may have, as a share of the force of each pair of trees; 0: the leaves always answer
	double forceError = 0;
};

struct DemoOptions
{
	std::string mesh;                 ///< mesh file for demos that take any mesh; empty: a generated mesh
	std::optional<ist::UpAxes> up;    ///< turn of that mesh
	std::string cache;                ///< folder for trees; empty: trees are not stored
	long long spheres = 0;            ///< number of spheres; 0: the demo's default
	ContactCacheChoice contactCache;  ///< used by programs that run demos; see BrowsableDemo::setContactCache
	ist::Progress progress;
	std::function<void(const std::string&)> say;
};

/// One demo: a scene that steps, draws itself and judges its results. It needs no window and no graphics library. Only one thread may use
/// it.
class BrowsableDemo
{
public:
	virtual ~BrowsableDemo() = default;

	/// Makes meshes and trees, which may take seconds. Call it once, before anything else.
	virtual std::optional<ist::Error> prepare(const DemoOptions& options) = 0;
	/// Restarts the demo with the present parameters.
	virtual std::optional<ist::Error> restart() = 0;
	/// Makes one step; `seconds` must be positive and finite.
	virtual void step(double seconds) = 0;
	virtual double stepSize() const { return 1.0 / 240; }
	/// Time after which the figures are final [s].
	virtual double duration() const = 0;
	/// Time since the start [s].
	virtual double time() const = 0;

	virtual void draw(const DrawChoice& choice, DrawList& list) = 0;
	virtual Viewpoint viewpoint() const = 0;
	/// Drawings that the demo shows at first.
	virtual DrawChoice firstChoice() const { return {}; }
	virtual std::vector<Parameter> parameters() { return {}; }
	virtual std::vector<Figure> figures() const = 0;
	virtual std::vector<Curve> curves() const { return {}; }
	/// Charts over quantities other than time, which are drawn in a corner of the picture.
	virtual std::vector<scenes::Chart> charts() const { return {}; }
	/// Report rows for the user: which model answers for which pair, what sleeps, what an answer costs.
	virtual std::vector<std::string> report() const { return {}; }
	/// The report as one JSON value; empty where there is none.
	virtual std::string reportJson() const { return {}; }
	/// Saves the bodies of the first world as a scene file (SceneSaver.h). Returns sentences on what such a file cannot hold.
	virtual ist::Result<std::vector<std::string>> saveScene(const std::string& /*path*/)
	{
		return ist::Error{"this demo has no world of bodies that a scene file could hold"};
	}
	/// One half of the picture.
	struct Half
	{
		BrowsableDemo* demo = nullptr;
		std::string title;
	};
	/// Scenes that are shown side by side under one camera, from left to right. Empty: this demo fills the picture. Of the halves,
	/// callers may use only `draw` and `grab`.
	virtual std::vector<Half> halves() { return {}; }
	/// True when Bullet's own contact can be used in the same scene.
	virtual bool hasStockSide() const { return false; }
	/// Chooses Bullet's own contact or ours from the next `restart` on; only where `hasStockSide`.
	virtual void useStockContact(bool /*on*/) {}

	/// Sets the contact cache from the next step on; it stays over `restart`.
	virtual void setContactCache(const ContactCacheChoice& /*contactCache*/) {}

	/// Grabs the body that the ray meets. Returns the distance along the ray, or nothing.
	virtual std::optional<double> grab(const ist::Vec3& /*from*/, const ist::Vec3& /*direction*/) { return std::nullopt; }
	/// Grabs the body that a device should move, unless one is held already. Returns false when there is none.
	virtual bool grabTool() { return false; }
	/// From now on, until `restart`, a hand at the device feels the demo's tool, or a ball where it has none, by a thread of its own
	/// (ForceHand). The device must outlive this. Refused, with the reason: a demo without a world of bodies, two halves, and what
	/// ForceHand::make refuses.
	virtual std::optional<ist::Error> feelWith(devicebridge::Device& /*device*/, double /*scale*/)
	{
		return ist::Error{halves().empty() ? "this demo has no world of bodies that a hand could feel"
										   : "beside stock Bullet a hand feels nothing: show the demo alone"};
	}
	/// Ends that: the tool is in the world again, and the device is at zero.
	virtual void stopFeeling() {}
	/// What the hand feels, in words; empty while no device feels.
	virtual std::string felt() const { return {}; }
	/// Moves the target of the held body's grip by `shift` [m] and rotates it by `turn` [rad, World].
	virtual void drag(const ist::Vec3& /*shift*/, const ist::Vec3& /*turn*/) {}
	virtual void release() {}
	/// Prevents all bodies from sleeping.
	virtual void keepAwake(bool /*on*/) {}
};
}  // namespace browser
