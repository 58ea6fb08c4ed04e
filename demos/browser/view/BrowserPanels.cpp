// SPDX-License-Identifier: Zlib
#include "demos/browser/view/Browser.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace browser
{
namespace
{
const ImVec4 kGood{0.0f, 0.45f, 0.33f, 1}, kBad{0.78f, 0.25f, 0.0f, 1}, kQuiet{0.42f, 0.45f, 0.50f, 1};

/// Draws error bars over the line that ImGui has just drawn between two values.
void drawErrorBars(const Curve& curve, float least, float most)
{
	const float pad = ImGui::GetStyle().FramePadding.x, tall = ImGui::GetStyle().FramePadding.y;
	const ImVec2 lower = ImGui::GetItemRectMin(), upper = ImGui::GetItemRectMax();
	const size_t count = curve.errors.size();
	const auto height = [&](float value) {
		return upper.y - tall - (upper.y - lower.y - 2 * tall) * std::clamp((value - least) / (most - least), 0.0f, 1.0f);
	};
	ImDrawList& to = *ImGui::GetWindowDrawList();
	const size_t stride = std::max<size_t>(1, count / 60);
	for (size_t i = 0; i < count; i += stride)
	{
		const float x = lower.x + pad + (upper.x - lower.x - 2 * pad) * float(i) / float(count - 1);
		to.AddLine({x, height(curve.values[i] - curve.errors[i])}, {x, height(curve.values[i] + curve.errors[i])},
			IM_COL32(0, 114, 178, 110), 1.5f);
	}
}

/// Draws range, newest value and line of a curve, with its error bars.
void plot(const Curve& curve, float height)
{
	if (curve.values.size() < 2) return;
	const bool bars = curve.errors.size() == curve.values.size();
	float least = curve.values.front(), most = least;
	for (size_t i = 0; i < curve.values.size(); ++i)
	{
		least = std::min(least, curve.values[i] - (bars ? curve.errors[i] : 0));
		most = std::max(most, curve.values[i] + (bars ? curve.errors[i] : 0));
	}
	most += 1e-6f * std::fabs(most) + 1e-30f;
	char text[128];
	if (bars)
		std::snprintf(text, sizeof text, "%.4g +- %.2g %s", double(curve.values.back()), double(curve.errors.back()), curve.unit.c_str());
	else
		std::snprintf(
			text, sizeof text, "%.4g %s  (%.3g to %.3g)", double(curve.values.back()), curve.unit.c_str(), double(least), double(most));
	ImGui::TextUnformatted(curve.name.c_str());
	ImGui::SameLine();
	ImGui::TextColored(kQuiet, "%s", text);
	ImGui::PushItemWidth(-1);
	ImGui::PlotLines(("##" + curve.name).c_str(), curve.values.data(), int(curve.values.size()), 0, nullptr, least, most, {0, height});
	if (bars) drawErrorBars(curve, least, most);
	ImGui::PopItemWidth();
}

/// Draws a histogram of times, with bins of equal width.
void histogram(const char* name, const char* unit, const std::deque<float>& times, float height)
{
	if (times.size() < 10) return;
	std::vector<float> sorted(times.begin(), times.end());
	std::sort(sorted.begin(), sorted.end());
	const float least = sorted.front(), most = std::max(sorted[sorted.size() * 99 / 100], least * 1.001f + 1e-6f);
	constexpr int kParts = 32;
	float counts[kParts] = {};
	for (const float t : sorted) ++counts[std::clamp(int(kParts * (t - least) / (most - least)), 0, kParts - 1)];
	ImGui::TextUnformatted(name);
	ImGui::SameLine();
	ImGui::TextColored(kQuiet, "median %.3g, 99 %% within %.3g %s", double(sorted[sorted.size() / 2]), double(most), unit);
	ImGui::PushItemWidth(-1);
	ImGui::PlotHistogram(
		(std::string("##") + name).c_str(), counts, kParts, 0, nullptr, 0, *std::max_element(counts, counts + kParts), {0, height});
	ImGui::PopItemWidth();
}
}  // namespace

void Browser::drawTree(float width, float height)
{
	ImGui::SetNextWindowPos({0, 0});
	ImGui::SetNextWindowSize({width, height});
	ImGui::Begin("BulletHaptics", nullptr,
		ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar);
	ImGui::PushItemWidth(-1);
	ImGui::InputTextWithHint("##search", "Search demos", m_search, sizeof m_search);
	ImGui::PopItemWidth();
	ImGui::BeginChild("tree", {0, 0.27f * height});
	std::string group;
	bool open = false;
	const DemoEntry* chosen = nullptr;
	for (const DemoEntry* entry : searchDemos(m_search))
	{
		if (group != entry->group)
		{
			if (open) ImGui::TreePop();
			group = entry->group;
			ImGui::SetNextItemOpen(true, ImGuiCond_Once);
			open = ImGui::TreeNode(entry->group);
		}
		if (!open) continue;
		if (ImGui::Selectable(entry->name, entry == m_entry)) chosen = entry;
		if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", entry->about);
	}
	if (open) ImGui::TreePop();
	ImGui::EndChild();
	ImGui::Separator();
	if (m_entry) ImGui::TextWrapped("%s.", m_entry->about);
	if (const std::string wrong = message(); !wrong.empty())
	{
		ImGui::PushStyleColor(ImGuiCol_Text, kBad);
		ImGui::TextWrapped("%s", wrong.c_str());
		ImGui::PopStyleColor();
	}
	ImGui::BeginChild("rest");
	drawControls();
	drawParameters();
	drawFigures();
	drawCurves();
	drawChoices();
	drawDevices();
	drawProfile();
	drawPairs();
	ImGui::EndChild();
	ImGui::End();
	if (chosen) start(*chosen);
}

void Browser::drawControls()
{
	if (ImGui::Button(m_paused ? "Go on (i)" : "Pause (i)")) key(Key::Pause);
	ImGui::SameLine();
	if (ImGui::Button("Step (o)")) key(Key::Step);
	ImGui::SameLine();
	if (ImGui::Button("Restart (r)")) key(Key::Restart);
	float speed = float(m_speed);
	if (ImGui::SliderFloat("speed", &speed, 0.01f, 1, "%.2f of real time", ImGuiSliderFlags_Logarithmic)) m_speed = double(speed);
	if (bool halves = m_halves; m_hasStockSide && ImGui::Checkbox("beside stock Bullet (h)", &halves)) key(Key::Halves);
	if (m_demo) ImGui::TextColored(kQuiet, "time %.2f s, step %.3g ms", m_demo->time(), 1e3 * m_demo->stepSize());
}

void Browser::drawParameters()
{
	if (!m_demo) return;
	bool again = false;
	ImGui::PushItemWidth(-9 * ImGui::GetFontSize());
	for (Parameter& p : m_demo->parameters())
	{
		const std::string format = "%.4g " + (p.unit == "%" ? "%%" : p.unit);
		ImGui::SliderScalar(p.name.c_str(), ImGuiDataType_Double, p.value, &p.least, &p.most, format.c_str(),
			(p.logarithmic ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None) | ImGuiSliderFlags_AlwaysClamp);
		again = again || (p.restarts && ImGui::IsItemDeactivatedAfterEdit());
	}
	ImGui::PopItemWidth();
	if (again) key(Key::Restart);
}

void Browser::drawFigures()
{
	if (!m_demo || !ImGui::CollapsingHeader("Numbers", ImGuiTreeNodeFlags_DefaultOpen)) return;
	// After a hand has moved bodies, the closed form no longer applies.
	const bool final = !m_touched && m_demo->time() >= m_demo->duration() - 1e-9;
	for (const Figure& f : m_demo->figures())
	{
		ImGui::TextWrapped("%s: %.5g %s", f.name.c_str(), f.value, f.unit.c_str());
		if (!f.judged()) continue;
		const ImVec4 colour = !final ? kQuiet : f.ok() ? kGood : kBad;
		ImGui::TextColored(colour, "    %s %.5g +- %.2g",
			!final       ? m_touched ? "untouched" : "to be"
				: f.ok() ? "as expected,"
						 : "expected",
			f.expected, f.tolerance);
	}
}

void Browser::drawCurves()
{
	if (!m_demo || !ImGui::CollapsingHeader("Plots", ImGuiTreeNodeFlags_DefaultOpen)) return;
	const float height = 2.6f * ImGui::GetTextLineHeight();
	for (const Curve& curve : m_demo->curves()) plot(curve, height);
}

void Browser::drawChoices()
{
	if (!ImGui::CollapsingHeader("Show")) return;
	for (const DrawChoiceRow& row : drawChoiceRows()) ImGui::Checkbox(row.label, &(m_choice.*row.member));
	ImGui::Checkbox("ambient occlusion", &m_quality.occlusion);
	bool sleepless = m_noSleep;
	if (ImGui::Checkbox("nothing sleeps (d)", &sleepless)) key(Key::NoSleep);
}

void Browser::drawProfile()
{
	ImGui::SetNextItemOpen(m_profile);
	m_profile = ImGui::CollapsingHeader("Profile (p)");
	if (!m_profile) return;
	const float height = 2.6f * ImGui::GetTextLineHeight();
	if (m_demo) plot({"rate, of " + std::to_string(std::lround(m_speed / m_demo->stepSize())) + " Hz wanted", "Hz", m_rates}, height);
	histogram("steps", "us", m_stepTimes, height);
	histogram("pictures", "ms", m_frameTimes, height);
	const RenderCost& cost = m_renderer.cost();
	ImGui::TextWrapped("drawing: %.2f ms of our own, %.2f ms with OpenGL; %zu draw calls, %zu balls, %zu too small to be seen",
		1e-3 * cost.ownMicroseconds, 1e-3 * cost.microseconds, cost.drawCalls, cost.ballsDrawn, cost.ballsLeftOut);
	if (const RenderQuality drawn = quality(); drawn.pixels < 1)
		ImGui::TextWrapped(
			"for want of time: %.0f %% of the pixels along each side%s", 100 * drawn.pixels, drawn.shadowTaps > 0 ? "" : ", no shadows");
	ImGui::TextWrapped("%s", m_renderer.device().c_str());
}

void Browser::drawPairs()
{
	if (!m_demo || !ImGui::CollapsingHeader("What answers for which pair")) return;
	if (ImGui::Checkbox("leave out what is not needed", &m_contactCache.on)) m_demo->setContactCache(m_contactCache);
	float accepted = 100 * float(m_contactCache.forceError);
	if (ImGui::SliderFloat(
			"error accepted", &accepted, 0, 50, accepted > 0 ? "%.0f %% of the force" : "always the leaves", ImGuiSliderFlags_AlwaysClamp))
	{
		m_contactCache.forceError = 0.01 * double(accepted);
		m_demo->setContactCache(m_contactCache);
	}
	for (const std::string& row : m_demo->report()) ImGui::TextWrapped("%s", row.c_str());
}

void Browser::drawDevices()
{
	if (!ImGui::CollapsingHeader("Device")) return;
	ImGui::InputText("address", m_address, sizeof m_address);
	ImGui::Checkbox("feels forces", &m_wantsForces);
	if (ImGui::Button("use")) chooseDevice(m_address, m_wantsForces);
	ImGui::SameLine();
	if (ImGui::Button("let go")) chooseDevice("", false);
	ImGui::SameLine();
	if (ImGui::Button("look for devices")) lookForDevices();
	if (m_device)
	{
		const devicebridge::DeviceInfo& info = m_device->device().info();
		ImGui::TextWrapped(
			"%s: %.3g N, %.3g N/m, workspace %.3g m", info.model.c_str(), info.peakForce, info.maxStiffness, info.workspaceRadius);
		const std::string felt = m_demo ? m_demo->felt() : "", state = felt.empty() ? m_device->state() : felt;
		ImGui::TextColored(
			felt.empty() && state != "ready" ? kBad : kGood, "%s", state == "ready" ? "moves, without force" : state.c_str());
	}
	drawCalibration();
	for (const devicebridge::DriverReport& found : m_found)
	{
		const bool there = found.missing.empty();
		ImGui::BeginDisabled(!there);
		if (ImGui::SmallButton(found.scheme.c_str()))
		{
			std::snprintf(m_address, sizeof m_address, "%s", found.scheme.c_str());
			chooseDevice(m_address, m_wantsForces);
		}
		ImGui::EndDisabled();
		ImGui::SameLine();
		ImGui::TextWrapped("%s", there ? found.what.c_str() : found.missing.c_str());
	}
}

void Browser::drawCalibration()
{
	if (ImGui::Button("calibrate into")) calibrate(m_address, m_calibrationFile);
	ImGui::SameLine();
	ImGui::PushItemWidth(-1);
	ImGui::InputTextWithHint("##calibration", "file", m_calibrationFile, sizeof m_calibrationFile);
	ImGui::PopItemWidth();
	if (!m_fitting) return;
	ImGui::TextWrapped("%s", m_fitting->order().c_str());
	if (m_fitting->state() == devicebridge::GloveFitting::State::Pose && ImGui::Button("I hold it")) m_fitting->confirm();
}
}  // namespace browser
