// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Drivers/Glove/GloveFitting.h"
#include "demos/browser/base/DeviceHand.h"
#include "demos/browser/catalog/BesideStock.h"
#include "demos/browser/view/AffordableQuality.h"
#include "demos/browser/view/Gui.h"
#include "demos/browser/view/SceneView.h"

#include <deque>
#include <memory>
#include <string>

namespace browser
{
/// The keys of the browser; they are those of Bullet's example browser.
enum class Key
{
	Boxes,         ///< a
	Contacts,      ///< c
	NoSleep,       ///< d
	Frames,        ///< j
	Constraints,   ///< k, l
	Wireframe,     ///< w
	Surfaces,      ///< v
	Panels,        ///< g: grid and panels
	Pause,         ///< i, space
	Step,          ///< o
	Profile,       ///< p
	Shadows,       ///< s
	Restart,       ///< r
	Spheres,       ///< b: by size
	SphereLevels,  ///< e: by level
	Leaves,        ///< n
	Lenses,        ///< m
	Levels,        ///< t: what answers
	Pairs,         ///< u: by depth
	Halves,        ///< h: beside stock Bullet
	Picture,       ///< F1
	SaveScene      ///< F2: as a scene file
};

/// Picture of the whole browser with its panels, for a demo that ran for so many seconds of its own time. It needs no window and no
/// display.
ist::Result<Picture> takeBrowserPicture(const std::string& demo, double seconds, const DemoOptions& options, int width, int height);

/// The browser without its window: the running demo, what is shown, the panels. The owner of the window, if there is one, passes input
/// and time to it.
class Browser
{
public:
	Browser(Renderer& renderer, Gui& gui, const DemoOptions& options);

	/// Replaces the present demo. On an error that demo stays, and the error is shown.
	void open(const std::string& name);
	/// Saves the bodies as a scene file; the message says where, or why not.
	void saveScene(const std::string& path);
	/// Sets the mesh of the demos that take any, and opens its packing, as when a file is dropped on the window.
	void openMesh(const std::string& path);
	void key(Key key);
	/// From now on the device moves the demo's hand.
	void use(std::unique_ptr<DeviceHand> device);
	/// Opens a device and uses it, or lets the present one go if the address is empty. `forces`: feelForces(). If it cannot be opened, the
	/// present one stays, and the message says why. Ends a calibration.
	void chooseDevice(const std::string& address, bool forces);
	/// Asks each driver whether it has a device. The simulated ones are listed by name.
	void lookForDevices();
	/// What lookForDevices() found, drivers without a device last. `scheme` holds the address; that of a file still needs its path.
	const std::vector<devicebridge::DriverReport>& foundDevices() const { return m_found; }
	/// Begins to calibrate the glove at an address, for which it lets the present device go. advance() follows it; when the file is
	/// written, the glove is used with it. The message says why a calibration fails.
	void calibrate(const std::string& address, const std::string& file);
	/// Steps of the calibration; null before the first, and after one that failed or was left.
	devicebridge::GloveFitting* fitting() { return m_fitting.get(); }
	/// The device that is used; null: none.
	const DeviceHand* device() const { return m_device.get(); }
	/// From now on a hand at the device that is used feels the tools of demos, by a thread of its own.
	void feelForces();
	/// Mouse events on the scene. x and y are shares of the scene's width and height, from its upper left corner. `turns`: the modifier
	/// key is held.
	void press(double x, double y, bool onCamera);
	void drag(double x, double y, bool turns, bool pans, bool zooms);
	void releaseMouse();
	void wheel(double notches) { m_camera.zoom(notches); }

	/// Steps the demo by so many seconds of the wall clock, at its own speed. It stops early when a picture would take too long.
	void advance(double seconds);
	/// Draws scene and panels. Call it between `begin` and `end` of the Gui.
	void draw(unsigned target, int width, int height);

	/// Left edge and width of the scene in the picture [pixels].
	double sceneLeft() const { return m_sceneLeft; }
	double sceneWidth() const { return m_sceneWidth; }
	/// True once after F1 was pressed.
	bool wantsPicture();
	/// Draws in the best quality, however long that takes.
	void beautiful() { m_thrifty = false, m_quality = {}; }
	bool paused() const { return m_paused; }
	const BrowsableDemo* demo() const { return m_demo.get(); }
	/// The present problem: a file that could not be opened, or a device that does not answer. Empty: none.
	std::string message() const;
	DrawChoice& choice() { return m_choice; }
	Camera& camera() { return m_camera; }

private:
	void drawTree(float width, float height);
	void drawControls();
	void drawParameters();
	void drawFigures();
	void drawCurves();
	void drawProfile();
	void drawPairs();
	void drawChoices();
	void drawDevices();
	void drawCalibration();
	void followCalibration();
	void stepOnce(double h);
	double deviceScale() const;
	RenderQuality quality() const;
	bool start(const DemoEntry& entry);
	void toggleHalves();
	/// The view at `x`, a share of the scene's width. `x` becomes a share of the view's width. Null before the first picture.
	const SceneView* viewAt(double& x) const;
	double viewAspect() const { return m_views.empty() ? 1 : m_views.front().area.aspect(); }

	Renderer& m_renderer;
	Gui& m_gui;
	DemoOptions m_options;
	std::unique_ptr<DeviceHand> m_device;  // before the demo, whose thread may use it
	std::unique_ptr<BrowsableDemo> m_demo;
	bool m_feels = false;
	const DemoEntry* m_entry = nullptr;
	Camera m_camera;
	DrawChoice m_choice;
	ScenePainter m_painter;
	std::vector<SceneView> m_views;
	RenderQuality m_quality;
	AffordableQuality m_affordable;
	bool m_thrifty = false;  // true: quality follows the computer's speed, except for the occlusion, which the user chooses
	double m_stepping = 0;   // time for stepping between the last two pictures [s]
	std::string m_message;
	char m_search[64] = {};
	char m_address[512] = "sim:sigma7", m_calibrationFile[256] = "glove.json";
	std::unique_ptr<devicebridge::GloveFitting> m_fitting;
	bool m_wantsForces = true;
	std::vector<devicebridge::DriverReport> m_found;
	double m_owed = 0, m_speed = 1, m_sceneLeft = 0, m_sceneWidth = 0, m_sceneHeight = 0;
	double m_mouseX = 0, m_mouseY = 0, m_grip = 0;
	ContactCacheChoice m_contactCache;
	bool m_halves = false, m_hasStockSide = false;
	bool m_paused = false, m_panels = true, m_profile = false, m_noSleep = true, m_held = false, m_touched = false, m_wantsPicture = false;
	std::deque<float> m_stepTimes, m_frameTimes;  // [us, ms]
	std::vector<float> m_rates;                   // steps per second of the wall clock, for each picture
	double m_rate = 0;
};
}  // namespace browser
