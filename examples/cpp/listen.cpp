// Prints the robot and the chunks of a walk, and how many chunks it has missed.
//
// docs/ATTACH.md says how to build and start it.

#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "surefoot.h"

namespace {

struct Close {
    void operator()(surefoot_Reader *reader) const { surefoot_reader_close(reader); }
};

std::string text(const surefoot_Name &name) {
    const auto length = name.length < sizeof name.bytes ? name.length : sizeof name.bytes;
    return std::string(reinterpret_cast<const char *>(name.bytes), length);
}

void print_robot(const surefoot_Description &robot) {
    std::printf("robot %s:", text(robot.robot_name).c_str());
    for (uint32_t joint = 0; joint < robot.joints_len; ++joint) {
        std::printf(" %s", text(robot.joints[joint].name).c_str());
    }
    std::printf("\n");
}

void print_chunk(const surefoot_PlanChunk &chunk) {
    const surefoot_Waypoint &first = chunk.waypoints[0];
    const surefoot_Waypoint &last = chunk.waypoints[chunk.waypoints_len - 1];
    std::printf("chunk %lu of plan %lu, epoch %lu: %.3f to %.3f s\n",
                static_cast<unsigned long>(chunk.sequence),
                static_cast<unsigned long>(chunk.plan_id),
                static_cast<unsigned long>(chunk.epoch), first.time, last.time);
}

}  // namespace

int main(int count, char **arguments) {
    if (count != 2) {
        std::fprintf(stderr, "usage: listen INSTANCE\n");
        return 2;
    }
    char error[512];
    const std::unique_ptr<surefoot_Reader, Close> reader(
        surefoot_reader_open(arguments[1], 10.0, error, sizeof error));
    if (!reader) {
        std::fprintf(stderr, "%s\n", error);
        return 2;
    }
    std::printf("attached to %s\n", arguments[1]);
    std::fflush(stdout);
    // Messages are large: not on the stack.
    const auto chunk = std::make_unique<surefoot_PlanChunk>();
    const auto feedback = std::make_unique<surefoot_Feedback>();
    const auto robot = std::make_unique<surefoot_Description>();
    bool has_robot = false;
    unsigned long received = 0;
    for (;;) {
        // Asked before the last look for messages, so that none is left unread.
        const bool is_attended = surefoot_reader_is_attended(reader.get()) != 0;
        int result = 0;
        while ((result = surefoot_reader_next_feedback(reader.get(), feedback.get())) > 0) {
        }
        while ((result = surefoot_reader_next_description(reader.get(), robot.get())) > 0) {
            if (!has_robot) print_robot(*robot);
            has_robot = true;
        }
        while ((result = surefoot_reader_next_chunk(reader.get(), chunk.get())) > 0) {
            print_chunk(*chunk);
            ++received;
        }
        if (result < 0) {
            std::fprintf(stderr, "%s\n", surefoot_reader_error(reader.get()));
            return 2;
        }
        if (!is_attended && received > 0) break;
        std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
    std::printf("received %lu chunks, missed %lu\n", received,
                static_cast<unsigned long>(surefoot_reader_missed_chunks(reader.get())));
    return 0;
}
