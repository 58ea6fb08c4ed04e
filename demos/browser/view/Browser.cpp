// SPDX-License-Identifier: Zlib
#include "demos/browser/view/Browser.h"

#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"
#include "demos/browser/view/ChartView.h"

#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

using namespace ist;

namespace browser
{
namespace
{
constexpr size_t kTimes = 240;
constexpr double kLongestStep = 1.0 / 30;   // of a world that a hand feels [s]
constexpr double kMostSteppingShare = 0.7;  // share of the time between two pictures

void keep(std::deque<float>& times, double value)
{
	times.push_back(float(value));
	if (times.size() > kTimes) times.pop_front();
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
}  // namespace

Browser::Browser(Renderer& renderer, Gui& gui, const DemoOptions& options)
	: m_renderer(renderer),
	  m_gui(gui),
	  m_options(options),
	  m_contactCache(options.contactCache)
{
	// Pixels are expensive without a graphics card.
	m_thrifty = renderer.software();
	if (m_thrifty) m_quality.occlusion = false;
}

RenderQuality Browser::quality() const
{
	if (!m_thrifty) return m_quality;
	RenderQuality affordable = m_affordable.quality();
	affordable.occlusion = m_quality.occlusion;
	return affordable;
}

bool Browser::start(const DemoEntry& entry)
{
	std::unique_ptr<BrowsableDemo> made = makeDemo(entry, m_halves);
	std::optional<Error> error = made->prepare(m_options);
	if (!error) error = made->restart();
	if (error)
	{
		m_message = std::string(entry.name) + ": " + error->message;
		return false;
	}
	m_views.clear();
	m_demo = std::move(made);
	m_entry = &entry;
	m_hasStockSide = entry.make()->hasStockSide();
	m_message.clear();
	m_choice = m_demo->firstChoice();
	m_camera.set(m_demo->viewpoint());
	m_demo->keepAwake(m_noSleep);
	m_demo->setContactCache(m_contactCache);
	m_owed = 0;
	m_held = m_touched = false;
	m_stepTimes.clear();
	m_rates.clear();
	m_rate = 0;
	if (m_device) m_device->forget();
	if (m_feels) feelForces();
	return true;
}

void Browser::use(std::unique_ptr<DeviceHand> device)
{
	// The thread of a hand that feels uses the device until then.
	if (m_demo) m_demo->stopFeeling();
	m_feels = false;
	m_device = std::move(device);
}

void Browser::chooseDevice(const std::string& address, bool forces)
{
	m_message.clear();
	// A calibration in progress reads the serial line.
	if (m_fitting && m_fitting->state() != devicebridge::GloveFitting::State::Written) m_fitting.reset();
	if (address.empty()) return use(nullptr);
	auto opened = DeviceHand::open(address);
	if (!opened)
	{
		m_message = opened.error().message;
		return;
	}
	use(std::move(opened).value());
	if (forces) feelForces();
}

void Browser::lookForDevices()
{
	m_found.clear();
	for (const devicebridge::DriverReport& driver : devicebridge::DeviceRegistry().drivers())
	{
		if (driver.scheme == "sim")
			for (const std::string& name : devicebridge::simulatedProfileNames())
				m_found.push_back({"sim:" + name, driver.what, driver.missing});
		else m_found.push_back({driver.scheme + ":", driver.what, driver.missing});
	}
	std::stable_partition(m_found.begin(), m_found.end(), [](const devicebridge::DriverReport& found) { return found.missing.empty(); });
}

void Browser::calibrate(const std::string& address, const std::string& file)
{
	m_message.clear();
	m_fitting.reset();
	if (address.rfind("glove:", 0) == 0) use(nullptr);  // one program may read a serial line
	auto begun = devicebridge::GloveFitting::begin(address, file);
	if (begun) m_fitting = std::move(begun).value();
	else m_message = "no calibration: " + begun.error().message;
}

void Browser::followCalibration()
{
	using State = devicebridge::GloveFitting::State;
	if (!m_fitting || m_fitting->state() == State::Written) return;
	switch (m_fitting->update())
	{
	case State::Written:
		std::snprintf(m_address, sizeof m_address, "%s", m_fitting->calibratedAddress().c_str());
		chooseDevice(m_fitting->calibratedAddress(), false);
		break;
	case State::Failed:
		m_message = "no calibration: " + m_fitting->complaint();
		m_fitting.reset();
		break;
	default: break;
	}
}

void Browser::feelForces()
{
	m_feels = true;
	if (!m_demo || !m_device) return;
	if (const auto refused = m_demo->feelWith(m_device->device(), deviceScale())) m_message = "no forces: " + refused->message;
}

/// Metres of the scene per metre of the handle: the device's workspace is mapped to the visible area.
double Browser::deviceScale() const
{
	const double radius = m_device->workspaceRadius() > 0 ? m_device->workspaceRadius() : 0.1;
	return 0.3 * m_camera.viewpoint().distance / radius;
}

void Browser::toggleHalves()
{
	if (!m_entry)
	{
		m_halves = !m_halves;  // halves of the first demo
		return;
	}
	if (!m_hasStockSide)
	{
		m_message = std::string(m_entry->name) +
			(m_demo->halves().empty() ? ": Bullet's own contact has no answer to this scene" : ": stands beside stock Bullet already");
		return;
	}
	std::vector<double> values;
	for (const Parameter& p : m_demo->parameters()) values.push_back(*p.value);
	const DrawChoice choice = m_choice;
	const Viewpoint view = m_camera.viewpoint();
	m_halves = !m_halves;
	if (!start(*m_entry))
	{
		m_halves = !m_halves;
		return;
	}
	m_choice = choice;
	m_camera.set(view);
	const std::vector<Parameter> parameters = m_demo->parameters();
	for (size_t i = 0; i < parameters.size(); ++i) *parameters[i].value = values[i];
	key(Key::Restart);
}

void Browser::open(const std::string& name)
{
	const DemoEntry* entry = findDemo(name);
	if (entry) start(*entry);
	else m_message = "no demo is called " + name;
}

void Browser::openMesh(const std::string& path)
{
	const std::string before = m_options.mesh;
	m_options.mesh = path;
	open("packing");
	// A mesh that cannot be read is not tried again.
	if (!m_message.empty()) m_options.mesh = before;
}

void Browser::key(Key key)
{
	switch (key)
	{
	case Key::Boxes: m_choice.boxes = !m_choice.boxes; break;
	case Key::Contacts: m_choice.patches = m_choice.wrenches = !m_choice.wrenches; break;
	case Key::NoSleep:
		m_noSleep = !m_noSleep;
		if (m_demo) m_demo->keepAwake(m_noSleep);
		break;
	case Key::Frames: m_choice.frames = !m_choice.frames; break;
	case Key::Constraints: m_choice.constraints = !m_choice.constraints; break;
	case Key::Wireframe: m_choice.wireframe = !m_choice.wireframe; break;
	case Key::Surfaces: m_choice.surfaces = !m_choice.surfaces; break;
	case Key::Panels: m_choice.ground = m_panels = !m_panels; break;
	case Key::Pause: m_paused = !m_paused; break;
	case Key::Step:
		m_paused = true;
		if (m_demo) stepOnce(m_demo->stepSize());
		break;
	case Key::Profile: m_profile = !m_profile; break;
	case Key::Shadows: m_choice.shadows = !m_choice.shadows; break;
	case Key::Restart:
		if (m_demo)
			if (auto error = m_demo->restart()) m_message = error->message;
		if (m_feels) feelForces();
		m_held = m_touched = false;
		break;
	case Key::Spheres: m_choice.spheres = !m_choice.spheres; break;
	case Key::SphereLevels: m_choice.sphereLevels = !m_choice.sphereLevels; break;
	case Key::Leaves: m_choice.leaves = !m_choice.leaves; break;
	case Key::Lenses: m_choice.lenses = !m_choice.lenses; break;
	case Key::Pairs: m_choice.pairs = !m_choice.pairs; break;
	case Key::Levels: m_choice.levels = !m_choice.levels; break;
	case Key::Halves: toggleHalves(); break;
	case Key::Picture: m_wantsPicture = true; break;
	case Key::SaveScene:
		if (m_entry) saveScene(std::string(m_entry->name) + "-scene.json");
		break;
	}
}

void Browser::saveScene(const std::string& path)
{
	if (!m_demo) return;
	const auto leftOut = m_demo->saveScene(path);
	m_message = leftOut ? "scene file: " + path : leftOut.error().message;
	for (size_t i = 0; leftOut && i < leftOut.value().size(); ++i) m_message += (i == 0 ? ", without " : ", and ") + leftOut.value()[i];
}

bool Browser::wantsPicture() { return std::exchange(m_wantsPicture, false); }

const SceneView* Browser::viewAt(double& x) const
{
	const double pixel = m_sceneLeft + x * m_sceneWidth;
	for (const SceneView& view : m_views)
	{
		const double share = (pixel - view.area.left) / view.area.width;
		if (view.area.empty() || (&view != &m_views.back() && share >= 1)) continue;
		x = share;
		return &view;
	}
	return nullptr;
}

void Browser::press(double x, double y, bool onCamera)
{
	m_mouseX = x;
	m_mouseY = y;
	// A second button changes the kind of drag while a body is held.
	const SceneView* view = viewAt(x);
	if (m_held || onCamera || !m_demo || !view) return;
	const auto grip = view->demo->grab(m_camera.eye(), m_camera.ray(x, y, view->area.aspect()));
	if (!grip) return;
	m_held = m_touched = true;
	m_grip = *grip;
}

void Browser::drag(double x, double y, bool turns, bool pans, bool zooms)
{
	const double aspect = m_sceneHeight > 0 ? m_sceneWidth / m_sceneHeight : 1, right = (x - m_mouseX) * aspect, down = y - m_mouseY;
	m_mouseX = x;
	m_mouseY = y;
	if (!m_held)
	{
		if (pans) m_camera.pan(right, down, viewAspect());
		else if (zooms) m_camera.zoom(-20 * down);
		else m_camera.turn(right, down);
		return;
	}
	const Mat3 axes = m_camera.axes();
	const double height = m_camera.heightAt(m_grip, viewAspect());
	if (turns) m_demo->drag({}, 4 * (down * axes.column(0) + right * axes.column(1)));
	else if (zooms) m_demo->drag(height * down * axes.column(2), {});
	else m_demo->drag(height * (right * axes.column(0) - down * axes.column(1)), {});
}

void Browser::releaseMouse()
{
	if (m_held && m_demo) m_demo->release();
	m_held = false;
}

void Browser::stepOnce(double h)
{
	if (!m_demo) return;
	const double start = now();
	m_demo->step(h);
	keep(m_stepTimes, 1e6 * (now() - start));
}

void Browser::advance(double seconds)
{
	keep(m_frameTimes, 1e3 * seconds);
	m_affordable.took(seconds - std::exchange(m_stepping, 0));
	followCalibration();
	if (!m_demo || m_paused || !(seconds > 0)) return;
	const bool felt = !m_demo->felt().empty();
	if (m_device)
	{
		m_touched = true;
		if (!felt) m_device->update(*m_demo, deviceScale());
	}
	// A hand that feels is beside the world, which takes one step for it in each picture.
	const double h = felt ? std::clamp(seconds, m_demo->stepSize(), kLongestStep) : m_demo->stepSize();
	const double start = now(), most = kMostSteppingShare * std::max(seconds, 1.0 / 60);
	m_owed = std::min(m_owed + m_speed * std::min(seconds, 0.1), 0.1);
	int steps = 0;
	if (felt) m_owed = h;
	while (m_owed >= h)
	{
		stepOnce(h);
		++steps;
		m_owed -= h;
		if (now() - start > most) m_owed = 0;  // the demo runs slower than the clock, so that no backlog builds up
	}
	m_stepping = now() - start;
	// The number of steps varies by one between pictures, so the rate is a mean over about a quarter of a second.
	m_rate += std::min(1.0, 4 * seconds) * (steps / seconds - m_rate);
	if (m_rates.size() == kTimes) m_rates.erase(m_rates.begin());
	m_rates.push_back(float(m_rate));
}

void Browser::draw(unsigned target, int width, int height)
{
	const double panel = m_panels ? std::round(std::min(330 * m_gui.density(), 0.45 * width)) : 0;
	m_sceneLeft = panel;
	m_sceneWidth = width - panel;
	m_sceneHeight = height;
	if (width <= 0 || height <= 0) return;
	const PixelArea area{int(panel), width - int(panel), height};
	m_views = m_demo ? sceneViews(*m_demo, area) : std::vector<SceneView>{{nullptr, "", area}};
	m_painter.paint(m_views, m_choice, m_camera, m_renderer, target, quality(), true);
	if (m_demo && m_panels) drawCharts(*ImGui::GetBackgroundDrawList(), m_demo->charts(), panel, 0, m_sceneWidth, height);
	if (m_panels) drawTree(float(panel), float(height));
	else ImGui::GetForegroundDrawList()->AddText({10, 10}, IM_COL32(170, 30, 10, 255), message().c_str());
}

std::string Browser::message() const
{
	const std::string felt = m_demo ? m_demo->felt() : "", trouble = felt.empty() && m_device ? m_device->trouble() : felt;
	return m_message + (m_message.empty() || trouble.empty() ? "" : "\n") + trouble;
}
}  // namespace browser
