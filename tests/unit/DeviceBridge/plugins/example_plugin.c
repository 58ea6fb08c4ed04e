/* SPDX-License-Identifier: Zlib */
/* A complete plug-in in C: a handle that oscillates along x, whose cable the test can unplug. `address` is the amplitude in
 * millimetres. Compiled with BROKEN it is a plug-in that must be refused. */
#include "DeviceBridge/Plugins/devicebridge_plugin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct swing
{
	double amplitude, pushed;
	int pulled;
	unsigned long ticks;
};

/* For the test: the force of the last command of any device, a switch that unplugs all cables, and the number of open devices. */
DEVICEBRIDGE_PLUGIN_EXPORT volatile double example_last_force;
DEVICEBRIDGE_PLUGIN_EXPORT volatile int example_pulled, example_open_devices;

static void *swing_open(const char *address, struct devicebridge_info *info, char *why, size_t room)
{
	char *end;
	const double amplitude = 1e-3 * strtod(address, &end);
	struct swing *device;
	if (end == address || *end != '\0' || example_pulled)
	{
		snprintf(why, room, "%s", example_pulled ? "the cable of the swing is out" : "the amplitude must be a number of millimetres");
		return NULL;
	}
	device = calloc(1, sizeof *device);
	if (!device) return NULL;
	device->amplitude = amplitude;
	info->sensed = DEVICEBRIDGE_TRANSLATION | DEVICEBRIDGE_HAND;
	info->actuated = DEVICEBRIDGE_TRANSLATION;
	info->peak_force = info->continuous_force = 4;
	snprintf(info->model, sizeof info->model, "swing");
	__atomic_add_fetch(&example_open_devices, 1, __ATOMIC_SEQ_CST);
	return device;
}

static int swing_exchange(void *opened, const struct devicebridge_command *command, struct devicebridge_state *state, char *why, size_t room)
{
	struct swing *device = opened;
	const struct timespec millisecond = {0, 1000000};
	double phase;
	if (__atomic_load_n(&example_pulled, __ATOMIC_SEQ_CST))
	{
		snprintf(why, room, "the cable of the swing is out");
		return -1;
	}
	nanosleep(&millisecond, NULL);
	__atomic_store(&example_last_force, (double[]){command->force[2]}, __ATOMIC_SEQ_CST);
	phase = 1e-2 * (double)++device->ticks;
	state->position[0] = device->amplitude * sin(phase);
	state->linear[0] = 10 * device->amplitude * cos(phase);
	state->joints[10].position[0] = state->position[0];
	state->joints[10].orientation[3] = 1;
	state->joints[10].radius = 0.008;
	state->joints[10].tracked = 1;
	return 1;
}

static void swing_close(void *opened)
{
	__atomic_store(&example_last_force, (double[]){0}, __ATOMIC_SEQ_CST);
	__atomic_sub_fetch(&example_open_devices, 1, __ATOMIC_SEQ_CST);
	free(opened);
}

DEVICEBRIDGE_PLUGIN_EXPORT const struct devicebridge_plugin *devicebridge_plugin_entry(void)
{
	static const struct devicebridge_plugin plugin = {
#if defined(BROKEN_VERSION)
		sizeof plugin, 7, "oldversion",
#elif defined(BROKEN_SIZE)
		16, DEVICEBRIDGE_PLUGIN_VERSION, "short",
#else
		sizeof plugin, DEVICEBRIDGE_PLUGIN_VERSION, "example",
#endif
		"a handle that swings", NULL, swing_open, swing_exchange, swing_close};
	return &plugin;
}
