#include "server/config_jobs.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/config.h"
#include "tests/support/parse_config.h"

namespace pliant::server {
namespace {

void ExpectAll(const JobConfig& jobs) {
  EXPECT_EQ(jobs.jobs_max, 11U);
  EXPECT_EQ(jobs.jobs_per_tenant_max, 12U);
  EXPECT_EQ(jobs.bytes_max, 13U);
  EXPECT_EQ(jobs.bytes_per_tenant_max, 14U);
  EXPECT_EQ(jobs.running_max, 15U);
  EXPECT_EQ(jobs.keep_h, 16);
}

TEST(ConfigJobs, ReadsEveryFlagAndEveryKey) {
  ExpectAll(std::get<Config>(*Parse({"--jobs-max", "11", "--jobs-per-tenant-max", "12",
                                     "--jobs-bytes-max", "13", "--jobs-per-tenant-bytes-max", "14",
                                     "--jobs-running-max", "15", "--job-keep-h", "16"}))
                .jobs);
  ExpectAll(ParseYaml("jobs-max: 11\njobs-per-tenant-max: 12\njobs-bytes-max: 13\n"
                      "jobs-per-tenant-bytes-max: 14\njobs-running-max: 15\njob-keep-h: 16\n",
                      {})
                ->jobs);
}

TEST(ConfigJobs, RefusesWhatIsOutOfRange) {
  for (const std::string key : {"jobs-max", "jobs-per-tenant-max", "jobs-bytes-max",
                                "jobs-per-tenant-bytes-max", "job-keep-h"}) {
    const std::string flag = "--" + key;
    EXPECT_TRUE(Parse({flag.c_str(), "1"}).ok()) << key;
    EXPECT_EQ(Parse({flag.c_str(), "0"}).error().field, key);
  }
  EXPECT_TRUE(Parse({"--job-keep-h", "720"}).ok());
  EXPECT_EQ(Parse({"--job-keep-h", "721"}).error().field, "job-keep-h");
}

TEST(ConfigJobs, RunsHalfAsManyJobsAsThereAreWorkers) {
  EXPECT_EQ(JobBoundsOf({}, 8).running_max, 4U);
  EXPECT_EQ(JobBoundsOf({}, 1).running_max, 1U);
  EXPECT_EQ(JobBoundsOf({.running_max = 7}, 1).running_max, 7U);
  EXPECT_EQ(JobKeepOf({.keep_h = 2}).usual, std::chrono::minutes(120));
}

}  // namespace
}  // namespace pliant::server
