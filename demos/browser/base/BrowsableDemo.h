// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "demos/browser/drawing/DrawChoice.h"
#include "demos/browser/drawing/DrawList.h"
#include "demos/scenes/Pages/HtmlReport.h"

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace browser
{
/// A number that a demo found. With `expected`, from a closed form, a law of physics or an integration that shares no code with the
/// library, the demo is good only while the value is within `tolerance` of it.
struct Figure
{
	std::string name, unit;
	double value = 0;
	double expected = std::numeric_limits<double>::quiet_NaN();
	double tolerance = 0;  ///< in the unit

	bool judged() const { return !std::isnan(expected); }
	bool ok() const { return std::isfinite(value) && (!judged() || std::fabs(value - expected) <= tolerance); }
};

/// A number that can be turned while the demo runs.
struct Parameter
{
	std::string name, unit;
	double* value = nullptr;
	double least = 0, most = 1;
	bool restarts = false;  ///< takes effect when the demo begins anew
	bool logarithmic = false;
};

/// A line over time.
struct Curve
{
	std::string name, unit;
	std::vector<float> values;    ///< the newest last, one for every 1/60 s of the demo's own time
	std::vector<float> errors{};  ///< half lengths of the error bars, one for each value; or none
};

/// Where the camera begins.
struct Viewpoint
{
	ist::Vec3 target;
	double distance = 1;
	double yaw = 0.6, pitch = 0.35;  ///< [rad], about y and above the horizon
};

constexpr double kDegree = 0.017453292519943295;  ///< [rad]

/// What a demo may leave out of its queries (btISTContactCache).
struct ContactCacheChoice
{
	bool on = true;
	double maxError = 0.05;
	double forceError = 0;  ///< share of the force of each pair of trees that coarser levels may take; 0: the leaves always
};

struct DemoOptions
{
	std::string mesh;                 ///< file for demos that take any mesh; empty: a generated one
	std::string cache;                ///< folder where trees are kept; empty: nowhere
	long long spheres = 0;            ///< 0: what the demo thinks right
	ContactCacheChoice contactCache;  ///< for those who run demos; see BrowsableDemo::setContactCache
	ist::Progress progress;
	std::function<void(const std::string&)> say;
};

/// One demo: a scene that steps, shows itself and judges its numbers. No window, no graphics library. One owner thread.
class BrowsableDemo
{
public:
	virtual ~BrowsableDemo() = default;

	/// Meshes and trees; may take seconds. Once, before anything else.
	virtual std::optional<ist::Error> prepare(const DemoOptions& options) = 0;
	/// To the beginning, with the parameters as they are.
	virtual std::optional<ist::Error> restart() = 0;
	/// `seconds`: positive and finite.
	virtual void step(double seconds) = 0;
	virtual double stepSize() const { return 1.0 / 240; }
	/// Time after which the figures are final [s].
	virtual double duration() const = 0;
	/// Time since the beginning [s].
	virtual double time() const = 0;

	virtual void draw(const DrawChoice& choice, DrawList& list) = 0;
	virtual Viewpoint viewpoint() const = 0;
	/// What is best shown at first.
	virtual DrawChoice firstChoice() const { return {}; }
	virtual std::vector<Parameter> parameters() { return {}; }
	virtual std::vector<Figure> figures() const = 0;
	virtual std::vector<Curve> curves() const { return {}; }
	/// Over something else than time; drawn in the picture's corner.
	virtual std::vector<scenes::Chart> charts() const { return {}; }
	/// Rows for people: which model answers for which pair, what sleeps, what an answer costs.
	virtual std::vector<std::string> report() const { return {}; }
	/// The same as one JSON value; empty where there is none.
	virtual std::string reportJson() const { return {}; }
	/// One half of the picture.
	struct Half
	{
		BrowsableDemo* demo = nullptr;
		std::string title;
	};
	/// Scenes that are seen side by side under one camera, from the left; empty: this one, in the whole picture. Of the halves themselves
	/// only `draw` and `grab` are for others.
	virtual std::vector<Half> halves() { return {}; }
	/// True when Bullet's own contact can answer in the same scene.
	virtual bool hasStockSide() const { return false; }
	/// Which of both answers, from the next `restart` on; only where `hasStockSide`.
	virtual void useStockContact(bool /*on*/) {}

	/// From the next step on; stays over `restart`.
	virtual void setContactCache(const ContactCacheChoice& /*contactCache*/) {}

	/// Takes hold of the body that the ray meets; where on the ray, or nothing.
	virtual std::optional<double> grab(const ist::Vec3& /*from*/, const ist::Vec3& /*direction*/) { return std::nullopt; }
	/// Takes hold of the body that a device is meant to move, if it is not held already; false when there is none.
	virtual bool grabTool() { return false; }
	/// The held body's grip wants to be moved by `shift` [m] and turned by `turn` [rad, World].
	virtual void drag(const ist::Vec3& /*shift*/, const ist::Vec3& /*turn*/) {}
	virtual void release() {}
	/// Nothing may sleep.
	virtual void keepAwake(bool /*on*/) {}
};
}  // namespace browser
