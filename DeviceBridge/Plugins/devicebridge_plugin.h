/* SPDX-License-Identifier: Zlib */
#pragma once

/* The plug-in interface of DeviceBridge, in C: one shared library, libdevicebridge_NAME.so, makes the devices of the scheme NAME.
 * The host searches for it in the folders of DEVICEBRIDGE_PLUGIN_PATH (separated by colons) and in the plug-in folder of the
 * installation. It is loaded at its first use and never unloaded, because vendors' libraries have threads of their own.
 *
 * Every struct begins with its size as its maker knew it. The plug-in sets the size of devicebridge_plugin, and the host sets those
 * of the structs that it passes. Neither side may access a member beyond the size that the other side gives. New members are added
 * at the end. DEVICEBRIDGE_PLUGIN_VERSION changes when an old member changes, and then the plug-in is refused by name.
 *
 * Units are SI and radians. W is the device's world frame, H the frame of the handle. No call may throw or end the program. All
 * calls for one device come from one thread; calls for different devices may come from different threads. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C"
{
#endif

#define DEVICEBRIDGE_PLUGIN_VERSION 1u
/* const struct devicebridge_plugin *devicebridge_plugin_entry(void): the only symbol that the host looks up. */
#define DEVICEBRIDGE_PLUGIN_ENTRY "devicebridge_plugin_entry"
#define DEVICEBRIDGE_HAND_JOINTS 26

#if defined(_WIN32)
#define DEVICEBRIDGE_PLUGIN_EXPORT __declspec(dllexport)
#else
#define DEVICEBRIDGE_PLUGIN_EXPORT __attribute__((visibility("default")))
#endif

	/* Bits of `sensed` and `actuated`: x, y, z, rx, ry, rz, grip, joints of a hand. */
	enum
	{
		DEVICEBRIDGE_TRANSLATION = 0x07,
		DEVICEBRIDGE_ROTATION = 0x38,
		DEVICEBRIDGE_GRIP = 0x40,
		DEVICEBRIDGE_HAND = 0x80
	};

	/* The hand for which a device is made. */
	enum
	{
		DEVICEBRIDGE_LEFT = 1,
		DEVICEBRIDGE_RIGHT = 2
	};

	/* Bits of devicebridge_state.flags; the host sets all of them before each exchange. Force is sent only while all are set. */
	enum
	{
		DEVICEBRIDGE_CALIBRATED = 1,
		DEVICEBRIDGE_FORCES_ENABLED = 2,
		DEVICEBRIDGE_HAND_PRESENT = 4
	};

	/* Bits of devicebridge_info.assumed, each for one member: a limit that the device itself does not report. */
	enum
	{
		DEVICEBRIDGE_ASSUMED_PEAK_FORCE = 0x01,
		DEVICEBRIDGE_ASSUMED_CONTINUOUS_FORCE = 0x02,
		DEVICEBRIDGE_ASSUMED_PEAK_TORQUE = 0x04,
		DEVICEBRIDGE_ASSUMED_CONTINUOUS_TORQUE = 0x08,
		DEVICEBRIDGE_ASSUMED_MAX_STIFFNESS = 0x10,
		DEVICEBRIDGE_ASSUMED_MAX_ANGULAR_STIFFNESS = 0x20,
		DEVICEBRIDGE_ASSUMED_MAX_DAMPING = 0x40,
		DEVICEBRIDGE_ASSUMED_MAX_ANGULAR_DAMPING = 0x80,
		DEVICEBRIDGE_ASSUMED_DAMPING = 0x100,
		DEVICEBRIDGE_ASSUMED_ANGULAR_DAMPING = 0x200,
		DEVICEBRIDGE_ASSUMED_WORKSPACE_RADIUS = 0x400
	};

	/* Zero means unknown; nothing is sent to motors with an unknown peak. Texts end with a zero. */
	struct devicebridge_info
	{
		uint32_t size;
		uint32_t sensed, actuated;
		uint32_t handedness;                         /* DEVICEBRIDGE_LEFT or DEVICEBRIDGE_RIGHT; zero: either, or unknown */
		double peak_force, continuous_force;         /* [N] */
		double peak_torque, continuous_torque;       /* [N m] */
		double max_stiffness, max_angular_stiffness; /* largest stiffness at 1 kHz [N/m, N m/rad] */
		double max_damping, max_angular_damping;     /* largest damping at 1 kHz [N s/m, N m s/rad] */
		double resolution, angular_resolution;       /* [m, rad] */
		double workspace_radius;                     /* radius of the inscribed ball [m] */
		double nominal_rate;                         /* rate of the samples [Hz]; zero: 1000 */
		char model[64], maker[64], serial[64];
		char source[256]; /* origin of the values, in words */
		/* Members since 0.2.0: access them only if `size` includes them. */
		double damping, angular_damping; /* the mechanism's own [N s/m, N m s/rad] */
		uint32_t assumed, reserved;      /* bits DEVICEBRIDGE_ASSUMED_... for the values above */
		char profile[64];                /* profile in data/devices for values of zero; empty: by maker and model */
	};

	struct devicebridge_joint
	{
		double position[3];    /* position in W [m] */
		double orientation[4]; /* unit quaternion x, y, z, w */
		double radius;
		uint32_t tracked;
		uint32_t reserved;
	};

	struct devicebridge_state
	{
		uint32_t size;
		uint32_t flags, buttons;
		uint32_t velocity_estimated;  /* not zero: computed from positions, not measured */
		double position[3];           /* origin of H in W [m] */
		double rotation[9];           /* orientation of H in W, row major */
		double linear[3], angular[3]; /* velocity of the origin of H; angular velocity of H; in W */
		double grip_angle, grip_velocity;
		uint32_t hand_is_left, reserved;
		struct devicebridge_joint joints[DEVICEBRIDGE_HAND_JOINTS]; /* order and frames of XR_EXT_hand_tracking */
	};

	/* Wrench that the device is to exert on the hand from now on; zero without a command or after the last one has expired. */
	struct devicebridge_command
	{
		uint32_t size;
		uint32_t reserved;
		double force[3], torque[3]; /* on the hand, about the origin of H, in W [N, N m] */
		double grip_force;
	};

	/* Functions of a plug-in. They write explanations to `why`, which has space for `room` bytes, the final zero included. */
	struct devicebridge_plugin
	{
		uint32_t size, version;
		const char *name, *description;
		/* Returns 0 if no obstacle is known. Otherwise `why` says what is missing and what to install. The pointer may be null. */
		int (*missing)(char* why, size_t room);
		/* Opens a device; this may take seconds. `address` is the part after the scheme. If it returns null, `why` gives the reason. */
		void* (*open)(const char* address, struct devicebridge_info* info, char* why, size_t room);
		/* Exerts the command and waits at most 5 ms for a sample. Returns 1 if `state` is new, 0 if not.
		 * Returns -1 if the device is lost, and `why` gives the reason. */
		int (*exchange)(void* device, const struct devicebridge_command* command, struct devicebridge_state* state, char* why, size_t room);
		/* Closes the device and leaves it with zero force. */
		void (*close)(void* device);
	};

	typedef const struct devicebridge_plugin* (*devicebridge_plugin_entry_function)(void);

#ifdef __cplusplus
}
#endif
